// Reading proto3 JSON: fields that have their default may be missing, 64-bit integers are strings,
// enumerations are names, or numbers where the server is newer than this page.

export type Json = null | boolean | number | string | Json[] | JsonObject;
export interface JsonObject {
  [key: string]: Json | undefined;
}

export function obj(value: Json | undefined): JsonObject {
  return typeof value === 'object' && value !== null && !Array.isArray(value) ? value : {};
}

// Absent where the message is not there, which is not the same as an empty one.
export function maybe<T>(value: Json | undefined, read: (o: JsonObject) => T): T | undefined {
  return value === undefined || value === null ? undefined : read(obj(value));
}

export function list<T>(value: Json | undefined, read: (item: Json) => T): T[] {
  return Array.isArray(value) ? value.map(read) : [];
}

export function messages<T>(value: Json | undefined, read: (o: JsonObject) => T): T[] {
  return list(value, (item) => read(obj(item)));
}

// Also of 64-bit integers, which are exact up to 2^53: enough for stamps to a microsecond.
export function num(value: Json | undefined): number {
  if (typeof value === 'number') return value;
  if (typeof value !== 'string') return 0;
  if (value === 'Infinity') return Infinity;
  if (value === '-Infinity') return -Infinity;
  return Number(value);
}

export function str(value: Json | undefined): string {
  return typeof value === 'string' ? value : typeof value === 'number' ? String(value) : '';
}

export function bool(value: Json | undefined): boolean {
  return value === true;
}

// The name of an enumeration's value; `unknown` for what is missing or newer than this page.
export function name<T extends string>(
    value: Json | undefined, known: readonly T[], unknown: T): T {
  return known.find((one) => one === value) ?? unknown;
}

// Nanoseconds as milliseconds, what dates are made of here; 0 stays 0.
export function millis(value: Json | undefined): number {
  return num(value) / 1e6;
}
