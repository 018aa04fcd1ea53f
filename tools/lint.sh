#!/usr/bin/env bash
# lint.sh [all|quick|tidy-all] [BUILD]: runs ruff and mypy on all Python files and clang-format on all C++ files. With `all`, also runs clang-tidy on
# the C++ files that differ from main. `tidy-all` runs only clang-tidy, on all C++ files; this takes some ten minutes of two cores.
#
# Exit codes: 0 nothing found, 1 something found, 3 nothing found, but the checkers cannot be installed.
set -euo pipefail
cd "$(dirname "$0")/.."
what=${1:-all} build=${2:-build/release}
work=build/lint
tools=$work/python/bin

# Installs the pinned checkers once. Returns 3 if they cannot be installed, for example if PyPI cannot be reached.
fetch() {
  cmp -s tools/lint_requirements.txt "$work/installed.txt" && return
  rm -rf "$work/python" "$work/installed.txt"
  mkdir -p "$work"
  if ! { /usr/bin/python3 -m venv "$work/python" &&
         "$tools/pip" install -q --disable-pip-version-check --only-binary=:all: --no-deps --retries 1 --timeout 10 -r tools/lint_requirements.txt; } > "$work/pip.log" 2>&1; then
    echo "lint: ruff, mypy and clang-format cannot be installed and are not run: $(tail -n 1 "$work/pip.log")" >&2
    return 3
  fi
  cp tools/lint_requirements.txt "$work/installed.txt"
}

python() {
  local result=0
  "$tools/ruff" check --quiet . || result=1
  "$tools/mypy" --no-error-summary || result=1
  return $result
}

# Prints the first lines that clang-format would change.
format() {
  local found
  found=$(git ls-files --cached --others --exclude-standard '*.cpp' '*.h' | xargs "$tools/clang-format" --dry-run --Werror 2>&1) && return
  grep 'error:' <<< "$found" | head -n 20
  return 1
}

# Files of core/ and bindings/ that differ from the merge base with main; on main, from the previous commit.
changed() {
  local base
  base=$(git merge-base HEAD main 2>/dev/null) || base=$(git merge-base HEAD origin/main 2>/dev/null) || base=HEAD
  [ "$(git rev-parse "$base")" = "$(git rev-parse HEAD)" ] && base=$(git rev-parse --verify --quiet HEAD~1 || echo HEAD)
  { git diff --name-only --diff-filter=d "$base" -- core bindings; git ls-files --others --exclude-standard -- core bindings; } | grep -E '\.(cpp|h)$' | sort -u || true
}

# Source files of core/ and bindings/; their headers are checked with them.
sources() {
  git ls-files --cached --others --exclude-standard -- core bindings | grep '\.cpp$'
}

# tidy FILE COMMANDS. Clang 14 has no _Float16 on x86-64 and cannot capture structured bindings; it cannot read a file with either.
tidy() {
  local found
  found=$(clang-tidy --quiet -p "$2" "$1" 2> /dev/null) && return
  if grep -qE '_Float16 is not supported|reference to local binding' <<< "$found"; then
    echo "lint: $1 is not checked, because this Clang cannot read it"
    return
  fi
  echo "$found"
  return 1
}

# cpp FILES
cpp() {
  local files=$1
  if ! command -v clang-tidy > /dev/null; then
    echo "lint: clang-tidy is not installed (tools/setup.sh lint); C++ is not checked"
    return
  fi
  [ -z "$files" ] && return
  if [ ! -f "$build/compile_commands.json" ]; then
    echo "lint: $build/compile_commands.json is missing (make build writes it); C++ is not checked" >&2
    return 1
  fi
  # Clang cannot read GCC's precompiled header and does not have two of GCC's warnings. Without this header, a file must include all headers that it
  # needs.
  mkdir -p "$work/commands"
  sed -E 's/ -Winvalid-pch//; s/ -include [^ ]*cmake_pch\.hxx//; s/ -Wno-(restrict|stringop-overflow)//g' "$build/compile_commands.json" > "$work/commands/compile_commands.json"
  export -f tidy
  printf '%s\n' "$files" | xargs -P "$(nproc)" -I FILE bash -c 'tidy "$@"' tidy FILE "$work/commands"
}

if [ "$what" = tidy-all ]; then
  cpp "$(sources)" && exit 0 || exit 1
fi
result=0
fetch || result=$?
if [ "$result" = 0 ]; then
  python || result=1
  format || result=1
fi
if [ "$what" = all ]; then
  cpp "$(changed)" || result=1
fi
exit "$result"
