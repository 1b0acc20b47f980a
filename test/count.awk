# SPDX-License-Identifier: MIT
# Reads ctest's LastTest.log and prints "passed failed skipped": the cases of doctest programs, and one for each other
# test. A program that ends without its summary (a crash, a timeout) is one failure. A case that says "skipped: ..."
# was not run.
function close_test() {
  if (name == "") return
  if (has_summary && !(result == "failed" && bad == 0)) {
    skips = 0
    for (key in skipped_cases) skips++
    passed += good - skips; failed += bad; skipped += skips
  } else if (result == "passed") passed++
  else if (result == "skipped") skipped++
  else failed++
  name = ""
}
/^[0-9]+\/[0-9]+ Testing: / { close_test(); name = $0; result = "failed"; has_summary = 0; good = bad = 0; delete skipped_cases }
/^TEST CASE: / { current_case = $0 }
/MESSAGE: skipped:/ { skipped_cases[current_case] = 1 }
/^\[doctest\] test cases:/ {
  has_summary = 1
  split($0, part, "|")
  split(part[2], number, " "); good = number[1]
  split(part[3], number, " "); bad = number[1]
}
/^Test (Passed\.$|Pass Reason:)/ { result = "passed" }
/^Test (Skipped|Not Run)/ { result = "skipped" }
END { close_test(); print passed + 0, failed + 0, skipped + 0 }
