#!/usr/bin/env bash
# Every C++ file of the tree is as .clang-format writes it. Files given as arguments: only those.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/../.."

# Another version writes other lines.
for tool in clang-format-14 clang-format none; do
  if [ "$tool" = none ]; then
    echo "clang-format 14 is not installed: apt install clang-format-14" >&2
    exit 1
  fi
  if "$tool" --version 2>/dev/null | grep -q 'version 14\.'; then break; fi
done

if [ $# -eq 0 ]; then
  mapfile -t files < <(find engine haptics audio calibration shaders tests -name '*.h' -o -name '*.cpp' | sort)
else
  files=("$@")
fi
# One process at a time writes its lines, so that they do not mix.
if said=$(printf '%s\0' "${files[@]}" | xargs -0 -n 32 "$tool" --dry-run -Werror 2>&1); then
  echo "${#files[@]} files are formatted"
  exit 0
fi
mapfile -t bad < <(sed -n 's/^\(.*\):[0-9]*:[0-9]*: error: code should be clang-formatted.*/\1/p' <<<"$said" | sort -u)
if [ ${#bad[@]} -eq 0 ]; then
  echo "$said" >&2
  exit 1
fi
{
  echo "${#bad[@]} of ${#files[@]} files are not as .clang-format writes them. Run this and commit the result:"
  echo "  $tool -i ${bad[*]}"
} >&2
exit 1
