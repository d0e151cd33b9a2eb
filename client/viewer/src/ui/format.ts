// Numbers and times as people read them.

export const UNNAMED = 'unnamed';  // A robot that is localised and gave no name.

export function metres(m: number): string {
  if (!Number.isFinite(m)) return '–';
  return Math.abs(m) < 0.995 ? `${Math.round(m * 100)} cm` : `${m.toFixed(Math.abs(m) < 100 ? 2 : 1)} m`;
}

export function count(n: number): string {
  if (n >= 1e6) return `${(n / 1e6).toFixed(n >= 1e7 ? 0 : 1)} M`;
  if (n >= 1e4) return `${Math.round(n / 1e3)} k`;
  return String(n);
}

export function percent(share: number): string {
  return share < 0 ? '–' : `${Math.round(share * 100)} %`;
}

export function duration(ms: number): string {
  const s = Math.max(ms, 0) / 1000;
  if (s < 1) return `${Math.round(s * 1000)} ms`;
  if (s < 90) return `${s < 10 ? s.toFixed(1) : Math.round(s)} s`;
  if (s < 5400) return `${Math.round(s / 60)} min`;
  if (s < 172800) return `${Math.round(s / 3600)} h`;
  return `${Math.round(s / 86400)} days`;
}

const two = (n: number) => String(n).padStart(2, '0');

export function clock(ms: number): string {
  if (ms <= 0) return '–';
  const at = new Date(ms);
  return `${two(at.getHours())}:${two(at.getMinutes())}:${two(at.getSeconds())}`;
}

// With the day where it is not today.
export function moment(ms: number, nowMs: number): string {
  if (ms <= 0) return '–';
  const at = new Date(ms);
  if (at.toDateString() === new Date(nowMs).toDateString()) return clock(ms);
  return `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())} ${clock(ms)}`;
}

export function words(constant: string): string {
  const text = constant.toLowerCase().replaceAll('_', ' ');
  return text.charAt(0).toUpperCase() + text.slice(1);
}

export function plural(n: number, one: string, many = `${one}s`): string {
  return `${count(n)} ${n === 1 ? one : many}`;
}
