# awk -f compare.awk EXPECTED OUTPUT: is the output what a page says?
# Blanks count as one; "…" on a line of its own stands for any number of lines, at the end of a line for the rest
# of it, in place of a word for any word. Numbers may differ by 5 %, or by one in the last digit after the point:
# processors and libraries round differently. A page that shows nothing expects nothing in particular.
function number(word) { return word ~ /^[-+(]?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?[%x°,;):]*$/ }
function bare(word) { gsub(/[(%x°,;):]/, "", word); return word + 0 }
function last_digit(word,  digits) {
  digits = word
  if (word ~ /e/) return 0
  if (!sub(/^[^.]*\./, "", digits)) return 0  # a whole number may be a count
  gsub(/[^0-9]/, "", digits)
  return 10 ^ -length(digits)
}
function same(a, b,  x, y, size) {
  if (a == b || a == "…") return 1
  if (!number(a) || !number(b)) return 0
  x = bare(a)
  y = bare(b)
  size = (x < 0 ? -x : x)
  return (x - y < 0 ? y - x : x - y) <= 0.05 * size + 1.01 * last_digit(a)
}
function fits(i, j,  a, b, na, nb, k) {
  na = split(want[i], a, /[ \t]+/)
  nb = split(got[j], b, /[ \t]+/)
  for (k = 1; k <= na; k++) {
    if (k == na && a[k] == "…" && nb >= na) return 1
    if (k > nb || !same(a[k], b[k])) return 0
  }
  return na == nb
}
{ sub(/^[ \t]+/, ""); sub(/[ \t\r]+$/, "") }
$0 == "" { next }
FILENAME == ARGV[1] { want[++wanted] = $0; next }
{ got[++gotten] = $0 }
END {
  if (wanted == 0) exit 0
  j = 1
  skipping = 0
  for (i = 1; i <= wanted; i++) {
    if (want[i] == "…" || want[i] == "...") { skipping = 1; continue }
    if (skipping) while (j <= gotten && !fits(i, j)) j++
    if (j > gotten || !fits(i, j)) { print "the page says: " want[i]; print "the program:   " got[j]; exit 1 }
    j++
    skipping = 0
  }
  if (!skipping && j <= gotten) { print "the page does not say: " got[j]; exit 1 }
}
