"""Which broken 3MF packages does lib3mf refuse in strict mode?

usage: compare_3mf.py FOLDER    packages as the test `consortium` of fibar-formats leaves them, in target/tmp/3mf-cases
"""

import sys
from pathlib import Path

import lib3mf


def verdict(path: Path) -> str:
    """`refused` with lib3mf's own words, `warned`, or `accepted`."""
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    try:
        reader.ReadFromFile(str(path))
    except Exception as error:
        return f"refused: {str(error).splitlines()[0]}"
    if reader.GetWarningCount():
        return f"warned: {reader.GetWarning(0)}"
    meshes = model.GetMeshObjects()
    while meshes.MoveNext():
        if not meshes.GetCurrentMeshObject().IsManifoldAndOriented():
            return "accepted, but calls the mesh neither manifold nor oriented"
    return "accepted"


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    verdicts = {path.stem: verdict(path) for path in sorted(Path(sys.argv[1]).glob("*.3mf"))}
    for name, text in verdicts.items():
        print(f"{name:<42}{text}")
    broken = {name: text for name, text in verdicts.items() if name != "sound"}
    for word in ("refused", "warned", "accepted"):
        print(f"{word}: {sum(text.startswith(word) for text in broken.values())} of {len(broken)}")
    return 0 if verdicts.get("sound") == "accepted" else 1


sys.exit(main())
