# awk -v out=FOLDER -f code_blocks.awk PAGE...
# Writes each block ```cpp of a page to FOLDER/PAGE_N.inc, N from 1, and prints the names.
FNR == 1 { n = 0; page = FILENAME; sub(/.*\//, "", page); sub(/\.md$/, "", page) }
/^```cpp$/ { file = page "_" ++n ".inc"; print file; printf "" > (out "/" file); next }
/^```/ { if (file) close(out "/" file); file = "" }
file { print > (out "/" file) }
