// What the browser keeps for the page between visits. It may be full, forbidden, or written by others: then there is nothing.
const kPrefix = "cogrsim:";

export function recall(key: string): string | null {
  try {
    return localStorage.getItem(kPrefix + key);
  } catch {
    return null;
  }
}

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(kPrefix + key, value);
  } catch {
    // only remembered for as long as the page is open
  }
}
