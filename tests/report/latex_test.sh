#!/usr/bin/env bash
# The tables of a small study as LaTeX, in a paper of two columns: it compiles, and nothing sticks out of its column.
# usage: latex_test.sh ASLIO REPORT_FIXTURE; needs pdflatex.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$2" "$folder"
for rows in sequences methods; do
  "$1" report "$folder" --format tex --latex-rows "$rows" --output "$folder/tables.tex" --quiet
  cat >"$folder/paper.tex" <<'TEX'
\documentclass[10pt,twocolumn]{article}
\usepackage[T1]{fontenc}
\usepackage{booktabs}
\begin{document}
See Table~\ref{tab:fixture:ate_m}.
\input{tables.tex}
\end{document}
TEX
  for _ in 1 2; do
    (cd "$folder" && pdflatex -interaction=nonstopmode -halt-on-error paper.tex >log.txt) || { cat "$folder/log.txt"; exit 1; }
  done
  if grep -E "Overfull .hbox|undefined references|multiply defined" "$folder/paper.log"; then exit 1; fi
done
