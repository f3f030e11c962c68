# Set-up that the other scripts share; sourced, not run. Prints what it does.
# Rust (cargo) and Python 3.11 with pip are expected; the rest is installed when missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '\n== %s\n' "$*"; }

# logged NAME TEXT COMMAND...: says what is done, and keeps the command's output for the case that it fails.
logged() {
    local log=.cache/$1.log code=0
    say "$2"
    shift 2
    mkdir -p .cache
    "$@" >"$log" 2>&1 || code=$?
    [ "$code" = 0 ] && return
    tail -n 40 "$log" >&2
    echo "failed: $* (all of its output is in $PWD/$log)" >&2
    exit "$code"
}

# debian COMMAND PACKAGE...: installs Debian packages when the command is missing.
debian() {
    local command=$1
    shift
    command -v "$command" >/dev/null && return
    say "installing $* ($command is missing)"
    local sudo=""
    [ "$(id -u)" = 0 ] || sudo=sudo
    $sudo apt-get update -qq
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@"
}

# python_packages FILE: a private virtual environment in .venv with the packages of a requirements file. uv unpacks in seconds what
# takes pip a minute of a core. It does not read pip's settings: where there are any that it is not given here, pip does the work.
# None of the 10,000 modules is compiled, of which few are ever imported: Python compiles these, once.
unset PYTHONDONTWRITEBYTECODE
python_packages() {
    local stamp=.venv/.$(sha256sum "$1" | cut -c1-16)
    [ -e "$stamp" ] && return
    say "Python packages of $1 into .venv"
    local new=(python3 -m venv --without-pip .venv) pip=(python3 -m pip --python .venv/bin/python install --quiet --no-compile)
    local known='^(:env:\.find-links|.*\.(cert|default-timeout|timeout|disable-pip-version-check|no-cache-dir|root-user-action))='
    local place links=()
    [ -x .venv/bin/python ] || "${new[@]}"
    for place in ${PIP_FIND_LINKS-}; do links+=(--find-links "$place"); done
    if python3 -m pip config list | grep -vE "$known" >/dev/null || ! "${pip[@]}" --only-binary=:all: uv; then
        "${pip[@]}" --requirement "$1" pip
    elif ! env ${PIP_CERT:+SSL_CERT_FILE="$PIP_CERT"} .venv/bin/uv pip install --quiet --python .venv "${links[@]}" --requirement "$1" pip; then
        echo "uv cannot install them; pip does"
        "${new[@]}" --clear
        "${pip[@]}" --requirement "$1" pip
    fi
    touch "$stamp"
}

# cargo_tool NAME VERSION: a program from the Rust registry, built once into .cache/tools unless the machine has it.
cargo_tool() {
    PATH="$PWD/.cache/tools/bin:$PATH"
    command -v "$1" >/dev/null && return
    say "installing $1, which takes minutes"
    cargo install --quiet --locked --root .cache/tools "$1@$2"
}

# The folder in which cargo builds, wherever the user has put it.
target_dir() { echo "${CARGO_TARGET_DIR:-target}"; }

command -v cargo >/dev/null || { echo "cargo is missing: install Rust first (rustup)" >&2; exit 2; }
debian cc gcc
