// Reading proto3 JSON: fields that have their default may be missing, 64-bit integers are strings,
// enumerations are names, or numbers where the server is newer than this page.

export type Json = null | boolean | number | string | Json[] | JsonObject;
export interface JsonObject {
  [key: string]: Json | undefined;
}

export function obj(value: Json | undefined): JsonObject {
  return typeof value === 'object' && value !== null && !Array.isArray(value) ? value : {};
}

// Absent where it is not there, which is not the same as one that has its default.
export function maybe<T>(value: Json | undefined, read: (value: Json) => T): T | undefined {
  return value === undefined || value === null ? undefined : read(value);
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

// A whole number that is too large for a number here, as text.
export function whole(value: Json | undefined): string {
  return str(value) || '0';
}

// Reads an enumeration: a value's name without the prefix, '' for what is missing or newer than this
// page.
export function word<T extends string>(prefix: string, known: readonly T[]) {
  return (value: Json | undefined): T | '' => {
    const name = str(value);
    const short = name.startsWith(prefix) ? name.slice(prefix.length) : name;
    return known.find((one) => one === short) ?? '';
  };
}

// Nanoseconds as milliseconds, what dates are made of here; 0 stays 0.
export function millis(value: Json | undefined): number {
  return num(value) / 1e6;
}
