# What Doxygen reads instead of a header.
FNR == 1 {
  room = FILENAME
  sub(/.*include\/dynfilter\//, "", room)
  if (room !~ /\//) room = "front"
  sub(/\/.*/, "", room)
  in_c = FILENAME ~ /[.]h$/
  about = about_file()
}
# A comment before the namespace is on the file.
FNR == about { print "/// @file" }
in_c && /^\/\*/ && !told { told = sub(/^\/\*/, "/** @file\n *") }
# Namespaces `detail` are not for users. EXCLUDE_SYMBOLS leaves the bodies of their classes' functions.
/^namespace ([a-z_:]+::)?detail [{]/ { hidden = 1; print ""; next }
/[{]/ && hidden { hidden = 2 }
/^}  \/\/ namespace ([a-z_:]+::)?detail/ || ($0 == "}" && hidden == 1) { hidden = 0; print ""; next }
hidden { print ""; next }

# All that is declared belongs to the group of its folder.
/^(namespace dynfilter[a-z_:]* [{]|extern "C" [{])$/ { $0 = $0 " /** @addtogroup " room " */ /** @{ */" }
/^}  \/\/ namespace dynfilter/ || (above == "#ifdef __cplusplus" && $0 == "}") { $0 = "/** @} */ " $0 }

# What means the same everywhere is described here, once.
above !~ /^ *(\/\/\/|template <)/ || /fields\(\)/ {
  if (/^ *static .*[ &]fields\(\)/) say("The table of the parameters: names, units, ranges and meanings.")
  else if (/^struct [A-Za-z]+Params [{]/) say("Parameters: `fields()` has their units, ranges and meanings.")
  else if (/^(constexpr|inline) const char\* to_string\(/) say("The word for it in reports and in YAML.")
  else if (/[ &](params|options)\(\)/) say("The parameters that it works with.")
  else if (/ void reset\(\)/) say("Forgets all earlier frames.")
  else if (/ void clear\(\)/) say("Removes all content.")
  else if (/ std::size_t bytes\(\) const/) say("Memory that it takes [bytes].")
  else if (/ names\(\) const/) say("All names, in the order of the alphabet.")
  else if (/ find\(const std::string& (name|type)\) const/) say("Null if there is none of this name.")
  else if (/ virtual std::string name\(\) const = 0/) say("Its name in YAML and in reports.")
  else if (/ using Error::Error;/) say("Made from the message, which is one line.")
  else if (/\(std::string path, Stages |\(std::string name, std::string path, Stages /)
    say("`path`: its place in the pipeline, for messages. It owns the stages below it.")
}
above ~ /^ *template <class T, class = void>/ && /: std::false_type [{][}];/ { say("False, unless the host has what is named below.") }
above ~ /^ *template <class P>/ && /^Field<P> [a-z_]+\(const char\* name, [A-Za-z]+ P::\*member\)/ {
  say("The parameter that selects it, as an entry of a table of parameters.")
}
above ~ /^ *template <class P>/ && /^Field<P> (integer|flag|text|words|reals|integers)\(const char\* name/ {
  say("Like real(), for a member of another type.")
}
above ~ /^ *template <class[.][.][.] S>/ && /^StagePtr (first_available|any|all)\(/ {
  say("The combinator of this name, of pipeline/combinator_table.hpp.")
}

# Comments of C are comments of the reference, too. A summary does not end after an abbreviation.
in_c && /^ *\/\*[^*]/ { sub(/\/\*/, "/**") }
in_c && /[;,] +\/\*[^*]/ { sub(/\/\*/, "/**<") }
/\/\/\// {
  gsub(/e[.]g[.] /, "e.g.\\ ")
  gsub(/sec[.] /, "sec.\\ ")
  gsub(/al[.] /, "al.\\ ")
  gsub(/eq[.] /, "eq.\\ ")
}
# The contract of a rejector is a list.
room == "filters" && match($0, /^\/\/\/ (Formula|Votes|Needs|Abstains|Blind to|State|Cost): /) {
  $0 = "/// - **%" substr($0, 5, RLENGTH - 6) "**: " substr($0, RLENGTH + 1)
}
{ above = $0; print }

# The first line of a comment directly before `namespace dynfilter {`. 0: there is none.
function about_file(    line, number, begin, found) {
  while ((getline line < FILENAME) > 0) {
    ++number
    if (line == "namespace dynfilter {" && !found) found = begin
    if (line !~ /^\/\/\//) begin = 0
    else if (!begin) begin = number
  }
  close(FILENAME)
  return found
}

function say(text) {
  if ($0 ~ /\/\/\/</) return
  match($0, /^ */)
  $0 = substr($0, 1, RLENGTH) "/** " text " */ " substr($0, RLENGTH + 1)
}
