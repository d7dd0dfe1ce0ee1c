# awk -f excerpt.awk EXCERPT FILE: does each line of the excerpt stand in the file, in this order? A line "…" is
# passed over, so are blank lines and blanks around a line.
{ gsub(/^[ \t]+|[ \t\r]+$/, "") }
$0 == "" || $0 == "…" { next }
FILENAME == ARGV[1] { want[++wanted] = $0; next }
found < wanted && $0 == want[found + 1] { found++ }
END { if (found < wanted) { print want[found + 1]; exit 1 } }
