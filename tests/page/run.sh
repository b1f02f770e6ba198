#!/usr/bin/env bash
# The page of `bvhc view --html` in a headless Chromium, which is installed where that is possible. Exit status 77: there is none.
#
#   tests/page/run.sh [--only=WORDS]
#
# Environment: BVHC_TOOL   the program (default target/release/bvhc)
#              BVHC_PAGES  folder to keep pages and pictures of them in (default: a temporary one)
set -euo pipefail
cd "$(dirname "$0")/../.."

tool=${BVHC_TOOL:-target/release/bvhc}
browser() {
    local name
    for name in chromium chromium-browser google-chrome-stable google-chrome; do
        command -v "$name" && return
    done
    return 1
}
if ! browser >/dev/null; then
    root=""
    [ "$(id -u)" = 0 ] || root="sudo -n"
    if command -v apt-get >/dev/null 2>&1 && $root true 2>/dev/null; then
        # Ubuntu's package is only a pointer to a snap, which does not run everywhere: then there is none.
        DEBIAN_FRONTEND=noninteractive $root apt-get install -y -q --no-install-recommends chromium fonts-dejavu-core >/dev/null 2>&1 || true
    fi
fi
if ! chromium=$(browser) || ! "$chromium" --version >/dev/null 2>&1; then
    echo "SKIPPED: no Chromium is here, and none could be installed"
    exit 77
fi
if ! command -v node >/dev/null 2>&1; then
    echo "SKIPPED: no Node is here"
    exit 77
fi
if [ -n "${BVHC_PAGES:-}" ]; then
    folder=$BVHC_PAGES
    mkdir -p "$folder"
else
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
fi
node tests/page/page.mjs "$tool" "$chromium" "$folder" "$@"
