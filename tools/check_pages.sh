#!/usr/bin/env bash
# Checks the pages of a finished demo in headless Chromium, and lints their scripts.
#
# Needs: Node.js 18 or later with npm, and Chromium. Where one is missing, Debian's packages are installed, if apt-get may.
#        Packages of npm go to target/pages.
# Run:   tools/check_pages.sh MESOTEX DEMO [SCREENSHOTS]
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
mesotex=$(realpath "$1")
demo=$(realpath "$2")
screenshots=${3:+$(realpath -m "$3")}

for program in "${CHROMIUM:-chromium}" node npm; do
  command -v "$program" >/dev/null && continue
  apt-get update -qq
  DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium nodejs npm
  break
done
work="$root/target/pages"
mkdir -p "$work"
cp "$root/tools/pages/package.json" "$root/tools/pages/package-lock.json" "$work/"
cd "$work"
npm ci --silent --no-audit --no-fund

npx biome lint --error-on-warnings "$root"/src/report/web/*.js "$root"/src/report/web/*.css "$root/tools/check_pages.mjs"
node "$root/tools/check_pages.mjs" "$mesotex" "$demo/demo.sample" "$demo/demo.map.ply" "$demo/demo.view.html" \
  "$demo/demo.report.html" ${screenshots:+"$screenshots"}
