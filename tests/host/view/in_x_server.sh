#!/bin/sh
# Runs a program in an X server of its own. 77 (skipped) where the tools for that are missing.
for tool in xvfb-run xauth xdotool; do
    if ! command -v "$tool" >/dev/null; then
        echo "skipped: no $tool (packages xvfb, xauth, xdotool)"
        [ -z "${PALPATE_NEED_ALL:-}" ] || exit 1
        exit 77
    fi
done
exec xvfb-run -a -s "-screen 0 1280x720x24" "$@"
