#!/usr/bin/env python3
"""What each OpenCL driver makes of the kernels: the table of docs/verification.md. Where a driver is quick enough, ci.sh runs on it, too.

    tests/users/drivers.py BVHC [pocl] [intel] [rusticl] [oclgrind]      BVHC is the program, such as target/release/bvhc

Each driver is fetched into a temporary folder and shown to the program alone, so that nothing is installed but libclc, where rusticl is asked for: that reads it from
/usr/lib/clc alone. PoCL is the system's. Without names, all are tried. The exit status is 1 where a driver gives a wrong answer, or none though it is known to
give one, and 77 where none can be had.
"""

import argparse
import glob
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parent.parent.parent
LIBRARIES = "/usr/lib/x86_64-linux-gnu"
# Nothing that a driver does may take longer, in seconds.
PATIENCE = 1200


class Missing(Exception):
    """A driver that cannot be had here."""


def sh(*command, cwd=None):
    done = subprocess.run(list(map(str, command)), cwd=cwd, capture_output=True, text=True, check=False)
    if done.returncode:
        raise Missing(f"{command[0]} failed: {(done.stderr or done.stdout).strip().splitlines()[-1:]}")
    return done.stdout


def debian(folder, *packages):
    """Unpack Debian packages without installing them."""
    sh("apt-get", "download", "-q", *packages, cwd=folder)
    for package in folder.glob("*.deb"):
        sh("dpkg", "-x", package, folder)


def vendor(folder, library):
    if not Path(library).exists():
        raise Missing(f"{library} is not there")
    icd = folder / "vendors"
    icd.mkdir()
    (icd / "driver.icd").write_text(f"{library}\n")
    return {"OCL_ICD_VENDORS": str(icd), "OCL_ICD_FILENAMES": ""}


def pocl(folder):
    found = glob.glob("/etc/OpenCL/vendors/pocl*.icd")
    if not found:
        raise Missing("there is no PoCL in /etc/OpenCL/vendors")
    name = Path(found[0]).read_text().strip()
    return vendor(folder, name if name.startswith("/") else f"{LIBRARIES}/{name}")


def intel(folder):
    sh(sys.executable, "-m", "venv", folder / "venv")
    # The runtime names neither the compiler's libraries, which it loads, nor a loader that may come before the system's.
    sh(folder / "venv/bin/pip", "install", "-q", "intel-opencl-rt==2026.2.0", "intel-cmplr-lib-rt==2026.2.0")
    lib = folder / "venv/lib"
    return {**vendor(folder, lib / "libintelocl.so"), "LD_LIBRARY_PATH": f"{LIBRARIES}:{lib}"}


def rusticl(folder):
    if not Path("/usr/lib/clc/spirv64-mesa3d-.spv").exists():
        sh("apt-get", "install", "-y", "-q", "--no-install-recommends", "libclc-15")
    debian(folder, "mesa-opencl-icd", "libllvmspirvlib15", "libclang-cpp15", "libllvm15")
    lib = folder / LIBRARIES.lstrip("/")
    return {
        **vendor(folder, lib / "libRusticlOpenCL.so.1"),
        "LD_LIBRARY_PATH": f"{lib}:{folder}/usr/lib/llvm-15/lib",
        "RUSTICL_ENABLE": "llvmpipe",
        "GALLIUM_PIPE_SEARCH_DIR": str(lib / "gallium-pipe"),
    }


def oclgrind(folder):
    debian(folder, "oclgrind", "liboclgrind-21.10", "libclang-common-14-dev")
    lib = folder / "usr/lib"
    environment = {
        **vendor(folder, lib / "oclgrind/liboclgrind-rt-icd.so"),
        "LD_LIBRARY_PATH": f"{folder}{LIBRARIES}:{lib}/oclgrind",
        # Optimised code has a call that it does not know.
        "OCLGRIND_BUILD_OPTIONS": "-cl-opt-disable",
        # It follows each load and store, and writes here what is outside of its buffer.
        "OCLGRIND_LOG": str(folder / "invalid"),
    }
    # A check that finds nothing has to show that it would: this kernel stores behind its buffer.
    log = folder / "planted"
    (folder / "beyond.cl").write_text("kernel void beyond(global int *out) { out[get_global_id(0) + 4] = 1; }\n")
    (folder / "beyond.sim").write_text("beyond.cl\nbeyond\n4 1 1\n4 1 1\n<size=16 fill=0>\n")
    command = [folder / "usr/bin/oclgrind-kernel", "--build-options", "-cl-opt-disable", "beyond.sim"]
    subprocess.run(command, cwd=folder, env={**os.environ, **environment, "OCLGRIND_LOG": str(log)}, check=False, capture_output=True)
    if "Invalid write" not in (log.read_text() if log.exists() else ""):
        sys.exit("Oclgrind does not tell of a store behind a buffer, so what it does not tell of the kernels shows nothing")
    return environment


# How each is had, and how many rays it is asked: some are a million times slower than others.
DRIVERS = {"pocl": (pocl, 200_000), "intel": (intel, 200_000), "rusticl": (rusticl, 200), "oclgrind": (oclgrind, 1300)}


def row(program, cache, name, had, rays):
    """The row of a driver, and whether it is as it should be."""
    with tempfile.TemporaryDirectory() as scratch:
        try:
            environment = {**os.environ, **had(Path(scratch))}
        except Missing as why:
            return [name, "", "", "", "", f"not tried: {why}"], None
        command = [program, "verify", cache, "--device", "opencl:0", "--rays", rays, "--judge", 20, "--json", "--device-timeout", PATIENCE // 2]
        try:
            done = subprocess.run(list(map(str, command)), env=environment, capture_output=True, text=True, check=False, timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            return [name, "", rays, "", "", f"has not ended after {PATIENCE} s"], False
        sys.stderr.write(done.stderr)
        try:
            devices = json.loads(done.stdout)["files"][0]["devices"]
            cpu, device = devices
        except (ValueError, KeyError, IndexError):
            return [name, "", rays, "", "", f"exit code {done.returncode}: {done.stderr.strip().splitlines()[-1:]}"], False
        speed = [one["total"]["rays"] / (one["total"]["seconds"] or 1e-9) for one in devices]
        remark = device["deviation"] or "all bits equal"
        if log := environment.get("OCLGRIND_LOG"):
            invalid = Path(log).read_text() if Path(log).exists() else ""
            if invalid.strip():
                return [name, device["description"], f"{rays:,}", device["mismatches"], "", f"invalid accesses: {invalid.splitlines()[:3]}"], False
            remark += ", no load or store outside of a buffer"
        if rays >= 100_000:
            # What a CI engineer does with the program, on this driver.
            user = subprocess.run([REPOSITORY / "tests/users/ci.sh", program], env=environment, capture_output=True, text=True, check=False)
            if user.returncode:
                return [name, device["description"], f"{rays:,}", device["mismatches"], "", f"tests/users/ci.sh: {user.stderr.strip().splitlines()[-1:]}"], False
        cells = [name, device["description"], f"{rays:,}", device["mismatches"], f"{speed[1] / speed[0]:.3g}", remark]
        return cells, done.returncode == 0 and device["mismatches"] == 0 and device["total"]["rays"] == rays


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("drivers", nargs="*", metavar="DRIVER", help="of " + ", ".join(DRIVERS))
    args = parser.parse_args()
    unknown = set(args.drivers) - set(DRIVERS)
    if unknown:
        parser.error(f"there is no driver {', '.join(sorted(unknown))}; choose of {', '.join(DRIVERS)}")
    program = args.program.resolve()
    verdicts = []
    print("| driver | device | rays | mismatches | speed, CPU = 1 | answers |\n|---|---|--:|--:|--:|---|", flush=True)
    with tempfile.TemporaryDirectory() as scratch:
        # Two levels and spatial splits: every part of the kernel is asked.
        cache = Path(scratch) / "forest.bvhc"
        subprocess.run([program, "build", REPOSITORY / "samples/forest.gltf", "-o", cache, "--levels", "two", "--method", "sbvh", "-q"], check=True)
        for name in args.drivers or DRIVERS:
            cells, verdict = row(program, cache, name, *DRIVERS[name])
            print("| " + " | ".join(map(str, cells)) + " |", flush=True)
            verdicts.append(verdict)
    tried = [verdict for verdict in verdicts if verdict is not None]
    sys.exit(77 if not tried else 0 if all(tried) else 1)


if __name__ == "__main__":
    main()
