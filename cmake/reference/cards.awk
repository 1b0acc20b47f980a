# What Doxygen reads instead of a page: headings are labels that other pages refer to, and of links to pages that are not in
# the reference only the text remains.
FNR == 1 {
  name = FILENAME
  sub(/.*\//, "", name)
  sub(/[.]md$/, "", name)
  if (/^# / && name != "main_page") $0 = $0 " {#card_" name "}"
}
/^```/ { code = !code }
!code {
  while (opens_link($0) && (getline below) > 0) {
    sub(/^ +/, "", below)
    $0 = $0 " " below
  }
  rest = $0
  $0 = ""
  while (match(rest, /\[[^]]*\]\([^)]*\)/)) {
    link = substr(rest, RSTART, RLENGTH)
    text = target = link
    sub(/\]\(.*/, "", text)
    text = substr(text, 2)
    sub(/.*\]\(/, "", target)
    sub(/\)$/, "", target)
    if (target ~ /^[a-z_]+[.]md(#.*)?$/) {
      sub(/[.]md.*/, "", target)
      gsub(/`/, "", text)
      link = "@ref card_" target " \"" text "\""
    } else if (target !~ /^(https?:|@ref)/) {
      link = text
    }
    $0 = $0 substr(rest, 1, RSTART - 1) link
    rest = substr(rest, RSTART + RLENGTH)
  }
  $0 = $0 rest

  # Doxygen takes a quotation mark for the end of a text in backticks, and "20." for a list.
  while (match($0, /`[^`]+`/)) {
    text = substr($0, RSTART + 1, RLENGTH - 2)
    gsub(/&/, "\\&amp;", text)
    gsub(/</, "\\&lt;", text)
    gsub(/>/, "\\&gt;", text)
    $0 = substr($0, 1, RSTART - 1) "<code>" text "</code>" substr($0, RSTART + RLENGTH)
  }
  while (match($0, /\*\*[^*]+\*\*/))
    $0 = substr($0, 1, RSTART - 1) "<b>" substr($0, RSTART + 2, RLENGTH - 4) "</b>" substr($0, RSTART + RLENGTH)
  if (match($0, /^ +[0-9]+[.] /)) sub(/[.] /, "\\. ")
}
{ print }

# Whether a link continues in the next line.
function opens_link(line) {
  gsub(/`[^`]*`/, "", line)
  gsub(/\[[^]]*\]\([^)]*\)/, "", line)
  if (line ~ /\]\([^)]*$/) return 1
  gsub(/\[[^]]*\]/, "", line)
  return line ~ /\[[^]]*$/
}
