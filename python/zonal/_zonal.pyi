"""
Native part of the package `zonal`.
"""

from _typeshed import SupportsGetItem
from os import PathLike
from pathlib import Path
import typing

import numpy
import numpy.typing
from typing import Any, SupportsFloat, SupportsIndex, final

__all__ = ["ExchangeAreas", "Scene", "Solution", "StateSolver", "check", "combined_view_factors", "encode_png", "exchange", "gas", "keys", "page", "preview", "render", "run_command", "script_factors", "solve", "validate", "version", "view_factors", "write_dataset", "write_view_factors"]

@final
class ExchangeAreas:
    """
    Exchange areas of a scene.
    """
    def array(self, /, name: str) -> Any:
        """
        A matrix by its name, [matrices, zones, zones], or its row sums, [matrices, zones]; m².
        """
    def by_name(self, /, name: str) -> Any:
        """
        Sums of a matrix over names, [matrices, names, names], m².
        """
    @property
    def counts(self, /) -> tuple[int, int, int]:
        """
        Numbers of pairs by method, and of rays.
        """
    @property
    def diagnostics(self, /) -> list[tuple[str, str, str, str]]:
        """
        Notes and warnings: severity, code, part and text.
        """
    @property
    def grade(self, /) -> str:
        """
        The weakest grade among the areas.
        """
    @property
    def matrices(self, /) -> int:
        """
        Number of matrices: 1, or one for each band.
        """
    def name_index(self, /) -> numpy.typing.NDArray[numpy.int64]:
        """
        The index into `names` of each zone.
        """
    @property
    def names(self, /) -> list[str]:
        """
        Names of surfaces, of the medium and of panes.
        """
    def size(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """
        Area of patches, m², and volume of volume zones, m³.
        """
    def write(self, /, path: str | PathLike[str], progress: Any | None = None, threads: SupportsIndex | None = None) -> list[Path]:
        """
        Writes the areas: `.npz`, `.csv` or `.mtx`; returns the paths of all files.
        """
    @property
    def zones(self, /) -> int:
        """
        Number of zones.
        """

@final
class Scene:
    """
    A validated scene.
    """
    @property
    def bounds(self, /) -> tuple[list[float], list[float]]:
        """
        Lower and upper corner, m.
        """
    @property
    def cameras(self, /) -> list[str]:
        """
        Names of the cameras.
        """
    @property
    def name(self, /) -> str:
        """
        Name of the scene.
        """
    @property
    def notes(self, /) -> list[str]:
        """
        Notes and warnings of the reader.
        """
    @staticmethod
    def parse(text: str, base: str | PathLike[str], arrays: dict[str, typing.Any], name: str, threads: SupportsIndex | None = None) -> Scene:
        """
        Reads a document in which names of files may stand for arrays. Other files are looked for in the folder `base`.
        """
    @staticmethod
    def read(path: str | PathLike[str], threads: SupportsIndex | None = None) -> Scene:
        """
        Reads a scene file.
        """

@final
class Solution:
    """
    A solution.
    """
    def absorbed(self, /) -> dict[str, typing.Any]:
        """
        Columns of the power that surfaces absorb in light mode.
        """
    def array(self, /, name: str) -> Any:
        """
        An array by its name: a field, or a property of zones.
        """
    @staticmethod
    def array_names() -> list[str]:
        """
        The names of all arrays.
        """
    @property
    def bands(self, /) -> list[str]:
        """
        Names of the bands.
        """
    @property
    def cameras(self, /) -> list[str]:
        """
        Names of the cameras.
        """
    @property
    def diagnostics(self, /) -> list[tuple[str, str, str, str]]:
        """
        Notes and warnings of the solve and of its discretization error: severity, code, part and text.
        """
    def draw(self, /, settings: Any, progress: Any | None = None, threads: SupportsIndex | None = None) -> None:
        """
        Writes a picture, or the frames of an animation.
        """
    def export(self, /, settings: Any, progress: Any | None = None, threads: SupportsIndex | None = None) -> list[Path]:
        """
        Writes the solution for other programs; returns the paths of the files.
        """
    def face_table(self, /) -> dict[str, typing.Any]:
        """
        Columns of results by face of the meshes.
        """
    @staticmethod
    def from_bytes(data: bytes) -> Solution:
        """
        Reads a solution from the bytes of a file.
        """
    @property
    def grid(self, /) -> tuple[list[int], list[float], list[float]] | None:
        """
        Cells of the medium along each axis, lower and upper corner (m); none without a medium.
        """
    def group_array(self, /, group: str, name: str) -> Any:
        """
        The part of a light group in a field: `incident`, `direct`, `error` or `direct_error`, W/m².
        """
    @property
    def is_thermal(self, /) -> bool:
        """
        True for a solution of thermal mode.
        """
    @property
    def light_groups(self, /) -> list[str]:
        """
        Names of the light groups.
        """
    @property
    def name(self, /) -> str:
        """
        Name of the scene.
        """
    @property
    def names(self, /) -> list[str]:
        """
        Names of surfaces, of the medium and of panes.
        """
    @staticmethod
    def read(path: str | PathLike[str]) -> Solution:
        """
        Reads a solution from a file.
        """
    def relight(self, /, changes: Any, progress: Any | None = None, threads: SupportsIndex | None = None) -> Solution:
        """
        The solution with other light groups, reflectances or albedo.
        """
    @property
    def report(self, /) -> str:
        """
        The report as JSON.
        """
    def table(self, /) -> dict[str, typing.Any]:
        """
        Columns of results by name.
        """
    def to_bytes(self, /) -> bytes:
        """
        The bytes of the file.
        """
    def write(self, /, path: str | PathLike[str]) -> None:
        """
        Writes the file that `zonal solve` writes.
        """
    @property
    def zone_counts(self, /) -> tuple[int, int, int]:
        """
        Numbers of patches, voxel zones and pane zones.
        """

@final
class StateSolver:
    """
    A solver that keeps its factorization between states.
    """
    @property
    def counts(self, /) -> tuple[int, int, int]:
        """
        Number of zones, of patches, and of faces of meshes.
        """
    def face_index(self, /) -> numpy.typing.NDArray[numpy.int64]:
        """
        The face of each zone among those of all meshes, −1 for none.
        """
    def name_index(self, /) -> numpy.typing.NDArray[numpy.int64]:
        """
        The index into `names` of each zone.
        """
    @property
    def names(self, /) -> list[str]:
        """
        Names of surfaces, of the medium and of panes.
        """
    @staticmethod
    def of_areas(areas: ExchangeAreas, progress: Any | None = None, threads: SupportsIndex | None = None) -> StateSolver:
        """
        A solver of the states of a scene whose areas are known.
        """
    @staticmethod
    def read(path: str | PathLike[str]) -> StateSolver:
        """
        A solver from the file of `zonal exchange`.
        """
    def set(self, /, quantity: str, zones: Any, values: Any) -> None:
        """
        Sets a quantity of zones: `temperature` (K), `flux` (W/m², W/m³), `power` (W) or `emissivity`.
        """
    def set_surroundings(self, /, kelvin: SupportsFloat | SupportsIndex | None) -> None:
        """
        Sets the temperature of the surroundings, K; none for cold ones.
        """
    def size(self, /) -> numpy.typing.NDArray[numpy.float64]:
        """
        Area of patches, m², and volume of volume zones, m³.
        """
    def solve(self, /, progress: Any | None = None, threads: SupportsIndex | None = None) -> dict[str, typing.Any]:
        """
        Solves the state: columns by zone, by name and by face, and the balance.
        """

def check(scene: Scene, settings: str, memory_limit: SupportsIndex, progress: Any | None = None, threads: SupportsIndex | None = None) -> str:
    """
    What `zonal check --json` reports of a scene, as JSON.
    """

def combined_view_factors(factors: dict[str, typing.Any], group: Any, groups: SupportsIndex) -> dict[str, typing.Any]:
    """
    The view factors of unions of faces: `group` numbers the union of each face, below `groups`.
    """

def encode_png(radiance: Any, exposure: SupportsFloat | SupportsIndex | None = None, stops: SupportsFloat | SupportsIndex = 0.0, contrast: SupportsFloat | SupportsIndex = 1.0) -> bytes:
    """
    Radiance, [height, width, 3], as the bytes of a PNG: exposed, tone-mapped, 8 bits.
    """

def exchange(scene: Scene, settings: Any, progress: Any | None = None, threads: SupportsIndex | None = None) -> ExchangeAreas:
    """
    Computes the exchange areas of a scene.
    """

def gas(model: str | None, settings: Any) -> str:
    """
    What `zonal gas --json` reports, as JSON; without a model the models.
    """

def keys() -> list[tuple[str, str, str, str, str]]:
    """
    The keys of scene files: path, type, unit, default, description.
    """

def page(solution: Solution, max_vertices: SupportsIndex, first_band: SupportsIndex = 0, progress: Any | None = None, threads: SupportsIndex | None = None) -> str:
    """
    The page of the viewer with the data of the solution, one HTML text.
    """

def preview(solution: Solution, camera: Any, settings: Any, threads: SupportsIndex | None = None) -> tuple[bytes, tuple[float, float] | None]:
    """
    A small PNG of the solution: light, or in thermal mode temperatures in false colours; with the range of the colours.
    """

def render(solution: Solution, camera: Any, settings: Any, progress: Any | None = None, threads: SupportsIndex | None = None) -> Any:
    """
    Radiance of a picture, [height, width, 3] of f4, W/(m² sr); or the values of a quantity, [height, width] of f8.
    """

def run_command(arguments: SupportsGetItem[int, str]) -> int:
    """
    Runs the command line, the name of the program first; returns its exit code.
    """

def script_factors(factors: dict[str, typing.Any], emissivity: SupportsGetItem[int, SupportsFloat | SupportsIndex], progress: Any | None = None, threads: SupportsIndex | None = None) -> "tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]":
    """
    Total exchange factors and their error radii, (faces, faces) each.
    """

def solve(scene: Scene, settings: str, run: Any, progress: Any | None = None, threads: SupportsIndex | None = None) -> Solution:
    """
    Solves a scene.
    """

def validate(settings: Any, progress: Any | None = None, threads: SupportsIndex | None = None) -> tuple[str, bool]:
    """
    Runs cases with known answers: verdicts as JSON, and whether all hold.
    """

def version() -> str:
    """
    The version of the package.
    """

def view_factors(mesh: Any, obstacles: SupportsGetItem[int, Any], settings: Any, progress: Any | None = None, threads: SupportsIndex | None = None) -> dict[str, typing.Any]:
    """
    The view factors of the faces of a mesh: arrays by name.
    """

def write_dataset(settings: Any, progress: Any | None = None, threads: SupportsIndex | None = None) -> list[str]:
    """
    Writes the file of `zonal dataset`; returns the notes on samples.
    """

def write_view_factors(factors: dict[str, typing.Any], path: str | PathLike[str], settings: Any, threads: SupportsIndex | None = None) -> None:
    """
    Writes the file that `zonal view-factors` writes.
    """
