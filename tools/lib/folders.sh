# Sourced by tools/quickstart: where results go.

# shellcheck shell=bash

# FOLDER, or FOLDER-2 and so on, the first that is not of another source than SOURCE (its file `source` names that), of a study or of
# somebody who did not say.
folder_for() {
  local source=$1 folder=$2 number=2
  while [ -e "$folder/results.csv" ] || [ -e "$folder/table.md" ] || [ -e "$folder/source" ]; do
    if [ ! -e "$folder/results.csv" ] && [ "$(cat "$folder/source" 2>/dev/null)" = "$source" ]; then break; fi
    folder=$2-$number
    ((++number))
  done
  printf '%s\n' "$folder"
}
