#!/usr/bin/env bash
# What is handed out: the crates that a registry would get, and the program with its manual pages and completions, as an archive and as a Debian package.
#
#   tests/package.sh           packs both crates, without compiling them, and puts the release build into an archive; each crate must stay below 2 MB
#   tests/package.sh --all     compiles the crates from their packages as well, builds the stripped program for the archive, and makes the Debian package; takes minutes
#
# The archive is target/package/bvhc-VERSION-TARGET.tar.gz, as [package.metadata.binstall] of Cargo.toml names it.
set -euo pipefail
cd "$(dirname "$0")/.."
# Scripts look there for what was built.
export CARGO_TARGET_DIR="$PWD/target"
verify=--no-verify profile=release
[ "${1:-}" = "--all" ] && verify="" profile=dist

fail() {
    echo "FAIL  $*" >&2
    exit 1
}

# A package that is new to the registry cannot find the other one there, so both are packed in one call.
rm -rf target/package
cargo publish --workspace --exclude bvhc-test-client --dry-run --quiet --allow-dirty $verify
seen=0
for crate in target/package/bvhc-*.crate target/package/tmp-crate/bvhc-*.crate; do
    [ -f "$crate" ] || continue
    bytes=$(wc -c <"$crate")
    printf '%9d bytes, %s\n' "$bytes" "$(basename "$crate")"
    [ "$bytes" -lt 2000000 ] || fail "a package must stay below 2 MB: see what is in it by cargo package --list"
    seen=$((seen + 1))
done
[ $seen -ge 2 ] || fail "$seen packages were found, not 2"

# What [package.metadata.deb] and the archive take from here.
cargo build --quiet --profile $profile
program=target/$profile/bvhc share=target/package/share
printf '%9d bytes, the program of the profile %s\n' "$(wc -c <$program)" $profile
mkdir -p $share/completions
$program man --out $share/man1 >/dev/null
$program completions bash >$share/completions/bvhc
$program completions zsh >$share/completions/_bvhc
$program completions fish >$share/completions/bvhc.fish

version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
target=$(rustc -vV | sed -n 's/^host: //p')
name=bvhc-$version-$target
folder=target/package/$name
mkdir -p "$folder"
cp $program README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE SECURITY.md format-spec/SPEC.md "$folder"
cp -r $share/man1 $share/completions "$folder"
tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner -C target/package -cf - "$name" | gzip -n >"$folder.tar.gz"
rm -rf "$folder"
printf '%9d bytes, %s\n' "$(wc -c <"$folder.tar.gz")" "$name.tar.gz"

# What a user gets from it: a program that runs, a page for each command, and three completions.
tried=$(mktemp -d)
trap 'rm -rf "$tried"' EXIT
tar -C "$tried" -xzf "$folder.tar.gz"
"$tried/$name/bvhc" build samples/stadium.obj -o "$tried/stadium.bvhc" -q
"$tried/$name/bvhc" check "$tried/stadium.bvhc" -q
holds() {
    local command
    for command in $("$program" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\) .*/\1/p' | grep -v '^help$'); do
        [ -s "$1/bvhc-$command.1$3" ] || fail "$1 has no manual page of $command"
    done
    [ -s "$1/bvhc.1$3" ] || fail "$1 has no manual page of the program"
    shift 1
    [ -s "$1/bvhc" ] || fail "$1 has no completion for bash"
}
holds "$tried/$name/man1" "$tried/$name/completions" ""
grep -q "^pkg-url = \"{ repo }/releases/download/v{ version }/{ name }-{ version }-{ target }{ archive-suffix }\"" Cargo.toml ||
    fail "[package.metadata.binstall] names another archive than $name.tar.gz"

[ $profile = dist ] || exit 0
if ! cargo deb --version >/dev/null 2>&1; then
    echo "SKIPPED: the Debian package, since cargo-deb is missing (cargo install cargo-deb)"
    exit 0
fi
cargo deb --quiet --no-build --no-strip --profile dist --output target/package/bvhc.deb
printf '%9d bytes, bvhc.deb\n' "$(wc -c <target/package/bvhc.deb)"
dpkg-deb -x target/package/bvhc.deb "$tried/deb"
"$tried/deb/usr/bin/bvhc" check "$tried/stadium.bvhc" -q
holds "$tried/deb/usr/share/man/man1" "$tried/deb/usr/share/bash-completion/completions" .gz
