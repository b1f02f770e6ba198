#!/usr/bin/env bash
# Does each test of what was cured fail with an older build of the program? One that passes with both shows nothing.
#
#   tests/cases_before.sh OLD [MODULE…]     OLD is a program built from an older commit, such as f236b7e:
#                                           git worktree add ../before f236b7e && (cd ../before && cargo build --release)
#
# The tests of these modules of tests/cli run with the program OLD; without any, those of cases, manners and patterns. There is a line for each case of the folder of
# cases and for each test. Controls were right before and must stay so; each says why. Exit code 1: a test or a case passes with OLD and is no control.
set -u
[ $# -ge 1 ] && [ -x "$1" ] || { sed -n '2,8s/^# \{0,1\}//p' "$0"; exit 2; }
old=$(realpath "$1")
shift
[ $# -gt 0 ] || set -- cases manners patterns
cd "$(dirname "$0")/.." || exit 2

# Why a case is right with both.
control() {
    case $1 in
        03-far-placed-mesh-baked/patch.gltf) echo "the patch at the origin, with which the far one is compared" ;;
        10-nul-at-end-obj/nul_long.obj) echo "its NULs lie behind byte 4096, where they were read over; nul.obj has them before" ;;
        21-damaged-cache-up-to-date/tri.obj) echo "the model was read rightly; a_file_that_was_damaged_cut_or_emptied_is_built_again is its test" ;;
        *) return 1 ;;
    esac
}

tests=0 same=0
passes() { echo "PASSES BEFORE  $1" && same=$((same + 1)); }
while IFS= read -r line; do
    case $line in
        "wrong: "*) echo "fails before   ${line#wrong: }" ;;
        "right: "*) if why=$(control "${line#right: }"); then echo "control        ${line#right: }: $why"; else passes "${line#right: }"; fi ;;
        "test "*"::"*" ... FAILED") line=${line#test } && echo "fails before   ${line% ... FAILED}" && tests=$((tests + 1)) ;;
        "test "*"::"*" ... ok")
            line=${line#test } line=${line% ... ok} tests=$((tests + 1))
            if why=$(control "$line"); then echo "control        $line: $why"; else passes "$line"; fi
            ;;
    esac
done < <(BVHC_PROGRAM=$old cargo test --test cli -- "${@/%/::}" --show-output 2>/dev/null)
echo "$tests tests; $same tests or cases pass with both programs and are no controls"
[ $tests -gt 0 ] && [ $same = 0 ]
