// The page's storage in the browser between visits. It may be full, forbidden, or written by others: then it is empty.
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
