# Takes a page apart: -v out=FOLDER. Writes FOLDER/commands and FOLDER/excerpts (tables, one block to a line)
# and the texts that they name.
BEGIN {
  system("mkdir -p '" out "'")
  printf "" > (out "/commands")
  printf "" > (out "/excerpts")
}
function finish_command() {
  if (command == "") return
  n++
  c = out "/command" n
  e = out "/expected" n
  printf "%s", command > c
  printf "%s", expected > e
  close(c)
  close(e)
  printf "%s\t%d\t%s\t%s\t%s\n", FILENAME, started, may_fail, c, e >> (out "/commands")
  command = ""
  expected = ""
}
/^```/ {
  if (inside == "") {
    inside = "other"
    if ($1 == "```console") {
      inside = "console"
      may_fail = ($2 == "fails") ? "fails" : "no"
    } else if ($2 == "in") {
      inside = "excerpt"
      m++
      excerpt = out "/excerpt" m
      printf "" > excerpt
      printf "%s\t%d\t%s\t%s\n", FILENAME, NR, $3, excerpt >> (out "/excerpts")
    }
  } else {
    if (inside == "console") finish_command()
    if (inside == "excerpt") close(excerpt)
    inside = ""
  }
  next
}
inside == "excerpt" { print > excerpt }
inside == "console" {
  if (continued) {
    command = command $0 "\n"
    continued = ($0 ~ /\\$/)
  } else if ($0 ~ /^\$ /) {
    finish_command()
    started = NR
    command = substr($0, 3) "\n"
    continued = ($0 ~ /\\$/)
  } else {
    expected = expected $0 "\n"
  }
}
