#!/usr/bin/env bash
# Makes reports and opens them in a browser: `tests/browser/run.sh [FOLDER]`. FOLDER, target/browser by default, receives reports, traces and screenshots.
# Needs node >= 18 with npm, and Chromium (SIMRUN_CHROMIUM, /usr/bin/chromium by default); without them it says so and passes.
# SIMRUN names a simrun that is built already.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
folder=$(mkdir -p "${1:-$root/target/browser}" && cd "${1:-$root/target/browser}" && pwd)
chromium=${SIMRUN_CHROMIUM:-/usr/bin/chromium}

skip() { echo "skipped: browser ($1)"; exit 0; }
[ -x "$chromium" ] || skip "no $chromium; SIMRUN_CHROMIUM names another"
command -v npm >/dev/null || skip "no npm"
node -e 'process.exit(parseInt(process.versions.node) < 18 ? 1 : 0)' || skip "node is older than 18"
(cd "$here" && PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1 npm ci --no-fund --no-audit --silent) || skip "npm could not fetch playwright-core"

# Commands on the pages name scenarios as seen from the repository.
cd "$root"
if [ -z "${SIMRUN:-}" ]; then
  cargo build --release --quiet
  SIMRUN=$(cargo build --release --quiet --message-format json | grep -o '"executable":"[^"]*/simrun"' | cut -d'"' -f4)
fi
export SIMRUN SIMRUN_CHROMIUM=$chromium

rm -rf "$folder/reports" "$folder/results" "$folder/screenshots"
mkdir -p "$folder/reports"
page() { "$SIMRUN" report "$folder/results/$1" -o "$folder/reports/$1.html"; }
"$SIMRUN" scenarios/warehouse.yaml --episodes 12 --quiet --out "$folder/results/warehouse"
page warehouse
"$SIMRUN" scenarios/sweeps/dwa_horizon_weight.yaml --episodes 3 --quiet --out "$folder/results/sweep"
page sweep
"$SIMRUN" reproduce gao2025 --episodes 20 --quiet --out "$folder/results/paper"
page paper
"$SIMRUN" tests/browser/outcomes.yaml --quiet --out "$folder/results/outcomes"
page outcomes

node "$here/test.mjs" "$folder/reports" "$folder/screenshots"
