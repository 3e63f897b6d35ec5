"""What this machine has for rendering."""

import dataclasses
import importlib.util
import os

from synthdepth.errors import BackendError
from synthdepth.render.backend import choose, llvm_candidates, remembered_probe


@dataclasses.dataclass(frozen=True, kw_only=True)
class Finding:
    """One thing that was looked at.

    Attributes:
        name: of the thing.
        ok: it is there and works.
        text: what was found, and what to do if it is missing.
    """

    name: str
    ok: bool
    text: str


def examine() -> list[Finding]:
    """Look at the variants, libLLVM, the denoiser, cores and memory."""
    cuda = remembered_probe("cuda")
    findings = [
        Finding(
            name="cuda",
            ok=cuda is None,
            text="renders" if cuda is None else f"{cuda}; needed only for rendering on a GPU",
        )
    ]
    for library in llvm_candidates():
        verdict = remembered_probe("llvm", library)
        findings.append(
            Finding(name="llvm", ok=verdict is None, text=f"{library}: {verdict or 'renders'}")
        )
    if not any(finding.ok for finding in findings if finding.name == "llvm"):
        findings.append(
            Finding(
                name="llvm",
                ok=False,
                text="no usable libLLVM: `pip install karellen-llvm-core`, or point "
                "DRJIT_LIBLLVM_PATH at libLLVM 19 or newer",
            )
        )
    scalar = remembered_probe("scalar")
    findings.append(
        Finding(name="scalar", ok=scalar is None, text=scalar or "renders, slowly: for checks only")
    )
    oidn = importlib.util.find_spec("mitsuba_oidn") is not None
    findings.append(
        Finding(
            name="denoiser",
            ok=oidn,
            text="mitsuba-oidn is installed" if oidn else "missing: `pip install mitsuba-oidn`",
        )
    )
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    findings.append(
        Finding(
            name="machine",
            ok=memory > 3,
            text=f"{cores} cores, {memory:.0f} GiB of memory; a worker needs up to 2 GiB",
        )
    )
    try:
        chosen = choose()
        findings.append(
            Finding(name="choice", ok=True, text=f"renders with {chosen.name}: {chosen.reason}")
        )
    except BackendError as error:
        findings.append(Finding(name="choice", ok=False, text=str(error)))
    return findings
