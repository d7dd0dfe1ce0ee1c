// The key that the studio asks for. It comes in the printed address behind the '#', which no browser sends to a server, and is kept
// for this tab and this server alone: not in a cookie, which every other server at the same address would be sent.
const kKey = "cogrsim:key";

/** The key from the address, which shows it no longer afterwards, else the one that this tab has had; "": none. */
export function takeKey(): string {
  const given = /^#token=([0-9a-f]+)$/.exec(location.hash)?.[1];
  if (given === undefined) return recallHere(kKey) ?? "";
  rememberHere(kKey, given);
  history.replaceState(null, "", location.pathname + location.search);
  return given;
}

/** Calls `renew` when the user opens another printed address in this tab: browsers only move within the page then. */
export function followKey(renew: () => void): void {
  addEventListener("hashchange", () => {
    if (location.hash.startsWith("#token=")) renew();
  });
}

/** The tab's storage over a reload; empty where the browser stores nothing. */
export function recallHere(key: string): string | null {
  try {
    return sessionStorage.getItem(key);
  } catch {
    return null;
  }
}

/** null: forgets it. */
export function rememberHere(key: string, value: string | null): void {
  try {
    if (value === null) sessionStorage.removeItem(key);
    else sessionStorage.setItem(key, value);
  } catch {
    // only known for as long as the page is open
  }
}
