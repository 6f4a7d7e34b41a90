"""The triangles of an OBJ (gzipped) as nine doubles each: triangles.py FILE.obj.gz OUT."""
import array
import gzip
import sys

points, numbers = [], array.array("d")
for line in gzip.open(sys.argv[1], "rt", errors="replace"):
    words = line.split()
    if words[:1] == ["v"]:
        points.append([float(x) for x in words[1:4]])
    elif words[:1] == ["f"]:
        corners = [int(w.split("/")[0]) for w in words[1:]]
        corners = [points[k - 1 if k > 0 else k] for k in corners]
        for b, c in zip(corners[1:], corners[2:]):
            numbers.extend(corners[0] + b + c)
with open(sys.argv[2], "wb") as out:
    numbers.tofile(out)
