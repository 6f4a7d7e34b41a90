"""Solutions: results on zones and by name, files, pictures, relighting."""

from __future__ import annotations

import contextlib
import importlib
import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast

import numpy as np
import numpy.typing as npt

from . import _zonal
from ._progress import Progress, observed
from ._types import Bands, Floats, Integers, Path, Quantity, Vector
from .diagnostics import Diagnostic, of_rows
from .errors import InputError

__all__ = ["Camera", "Solution", "encode_png", "load_solution"]


def memory_limit(gigabytes: float) -> int:
    """Bytes of a memory limit in GB."""
    if not (gigabytes > 0 and math.isfinite(gigabytes)):
        raise InputError("max_memory: give a positive number of gigabytes")
    return int(gigabytes * 1e9)


@dataclass(frozen=True)
class Camera:
    """A camera for :meth:`Solution.render`.

    Parameters
    ----------
    origin, target : point
        Position, and the point in the middle of the picture, m.
    up : vector
        Upward direction.
    fov : float
        Angle of view across the picture's width, degrees.
    aperture, focus : float, optional
        Diameter of the lens and distance in focus, m; a pinhole by default.

    Examples
    --------
    >>> import zonal as zn
    >>> zn.Camera([0.0, -3.0, 1.5], [0.0, 0.0, 1.0], fov=45.0).fov
    45.0
    """

    origin: Vector
    target: Vector
    up: Vector = (0.0, 0.0, 1.0)
    fov: float = 60.0
    aperture: float | None = None
    focus: float | None = None


class Solution:
    """A solved scene.

    Fields have a row for each zone: patches of surfaces first, then voxel zones, then pane zones. Band by band, they are B (radiosity) and the incident flux: the
    irradiance H of patches, the fluence G of volume zones. Arrays of up to three bands lie in the memory of the solver and are read-only.

    The errors of zones are those of the exchange, of direct light and of the solver. The error of the finite zones (discretization error) is known by name: it is part of
    the errors of :attr:`table`.

    Solutions are read by :func:`load_solution`, and can be pickled.

    Examples
    --------
    >>> import zonal as zn
    >>> scene = zn.Scene(mode="thermal")
    >>> scene.surface(room=([0, 0, 0], [1, 1, 1]), name="wall", emissivity=0.8, temperature=500, patch_size=0.5)
    >>> scene.medium([0, 0, 0], [1, 1, 1], cells=[2, 2, 2], extinction=0.5, heat_source=0)
    >>> solution = scene.solve(discretization_error=False)
    >>> solution.temperature.round(6)[-1]  # everything has one temperature
    np.float64(500.0)
    """

    def __init__(self, native: _zonal.Solution) -> None:
        self._native = native
        self._cache: dict[str, Any] = {}

    # Fields.

    def array(self, name: str) -> npt.NDArray[Any]:
        """An array by its name.

        Parameters
        ----------
        name : str
            A field (``radiosity``, ``incident``, ``direct``, ``error``, ``direct_error``, ``surroundings_error``; in thermal mode ``temperature``,
            ``temperature_error``, ``net``, ``net_error``) or a property of zones (``size``, ``kind``, ``name_index``, ``centre``, ``normal``,
            ``corners``, ``is_triangle``, ``facet``, ``face``, ``cell``, ``reflectance``, ``extinction``, ``emission``).

        Returns
        -------
        ndarray

        Raises
        ------
        KeyError
            If there is no such array.
        """
        if name not in self._cache:
            self._cache[name] = self._native.array(name)
        return cast("npt.NDArray[Any]", self._cache[name])

    @property
    def radiosity(self) -> Floats:
        """Radiosity B, (zones, bands), W/m2, direct light included."""
        return self.array("radiosity")

    @property
    def incident(self) -> Floats:
        """Irradiance H of patches, fluence G of volume zones, (zones, bands), W/m2, without direct light."""
        return self.array("incident")

    @property
    def direct(self) -> Floats:
        """Direct light in H and G, (zones, bands), W/m2; (0, bands) without direct light."""
        return self.array("direct")

    @property
    def error(self) -> Floats:
        """Estimated error of :attr:`incident` by the exchange and the solver, (zones, bands), W/m2; infinite where unknown."""
        return self.array("error")

    @property
    def direct_error(self) -> Floats:
        """Estimated error of :attr:`direct`, (zones, bands), W/m2; (0, bands) without direct light."""
        return self.array("direct_error")

    @property
    def surroundings_error(self) -> Floats:
        """The part of :attr:`error` that comes from the surroundings, W/m2; (0, bands) where they are dark."""
        return self.array("surroundings_error")

    @property
    def temperature(self) -> Floats:
        """Temperature, (zones,), K, in thermal mode; NaN where undefined."""
        return self._heat("temperature")

    @property
    def temperature_error(self) -> Floats:
        """Estimated error of :attr:`temperature` by the exchange and the solver, (zones,), K; 0 where it is given."""
        return self._heat("temperature_error")

    @property
    def net_flux(self) -> Floats:
        """Net emitted power, (zones,), W/m2 of patches, W/m3 of volume zones, in thermal mode."""
        return self._heat("net")

    @property
    def net_flux_error(self) -> Floats:
        """Estimated error of :attr:`net_flux` by the exchange and the solver, (zones,); 0 where it is given."""
        return self._heat("net_error")

    def _heat(self, name: str) -> Floats:
        if not self._native.is_thermal:
            raise InputError(f"{name}: a solution of light has none; solve a scene with mode=\"thermal\"")
        return self.array(name)

    # Zones.

    @property
    def zone_count(self) -> int:
        """Number of zones."""
        return sum(self._native.zone_counts)

    @property
    def patch_count(self) -> int:
        """Number of patches, the first zones."""
        return self._native.zone_counts[0]

    @property
    def voxel_count(self) -> int:
        """Number of voxel zones, which follow the patches."""
        return self._native.zone_counts[1]

    @property
    def pane_count(self) -> int:
        """Number of pane zones, the last zones."""
        return self._native.zone_counts[2]

    @property
    def names(self) -> list[str]:
        """Names of the surfaces, of the medium and of the panes."""
        return self._native.names

    @property
    def name_index(self) -> Integers:
        """The index into :attr:`names` of each zone, (zones,)."""
        return self.array("name_index")

    @property
    def size(self) -> Floats:
        """Area of patches, m2, and volume of volume zones, m3, (zones,)."""
        return self.array("size")

    @property
    def centre(self) -> Floats:
        """Centres of the zones, (zones, 3), m."""
        return self.array("centre")

    @property
    def normal(self) -> Floats:
        """Unit normals of patches and panes, (zones, 3); zero of voxel zones."""
        return self.array("normal")

    @property
    def bands(self) -> list[str]:
        """Names of the bands."""
        return self._native.bands

    @property
    def cameras(self) -> list[str]:
        """Names of the cameras of the scene."""
        return self._native.cameras

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self._native.name

    def zones_of(self, name: str) -> Integers:
        """The zones of a surface, of ``medium`` or of a pane, as indices.

        Parameters
        ----------
        name : str
            A name of :attr:`names`, or its part before a dot or a slash: ``wall`` stands for ``wall.x0``, ``wall.x1``, …

        Raises
        ------
        InputError
            If there is no such name.
        """
        return zones_of(name, self.names, self.name_index)

    # Results by name, report.

    @property
    def table(self) -> dict[str, Any]:
        """Results by name as columns, for ``pandas.DataFrame(solution.table)``.

        In thermal mode a row for each surface, the medium and each pane: ``name``, ``kind``, ``size`` (m2 or m3), ``temperature`` (K), ``net_flux`` (W/m2 or W/m3),
        ``net_power`` (W), and in scenes with sunlight ``absorbed_sunlight`` (W). In light mode a row for each surface: ``size``, ``net_flux``, ``net_power``; absorbed
        powers by band are apart in :attr:`absorbed`.

        ``net_power_error`` is the total error, as ``zonal solve`` prints it behind ±: the sum of ``net_power_exchange_error`` (exchange, direct light, solver) and
        ``net_power_discretization_error`` (finite zones). Likewise for ``net_flux`` and ``temperature``. Unknown numbers are NaN, unknown errors infinite; a total error
        is unknown where one of its parts is, so also where no discretization error was requested (``discretization_error=True``, the default in thermal mode).
        """
        return self._native.table()

    @property
    def absorbed(self) -> tuple[Floats, Floats]:
        """Absorbed power of each surface and its total error, (surfaces, bands) each, W, in light mode; the parts of the error are in :attr:`absorbed_errors`."""
        columns = self._native.absorbed()
        return columns["absorbed"], columns["absorbed_error"]

    @property
    def absorbed_errors(self) -> dict[str, Floats]:
        """The errors of :attr:`absorbed` by ``exchange`` (exchange, direct light, solver) and by ``discretization`` (finite zones), (surfaces, bands) each, W."""
        columns = self._native.absorbed()
        return {part: columns[f"absorbed_{part}_error"] for part in ("exchange", "discretization")}

    @property
    def face_table(self) -> dict[str, Any]:
        """Results by face of the meshes as columns, for ``pandas.DataFrame(solution.face_table)``, as ``zonal export --faces``.

        A row for each face, in the order of the meshes: ``mesh``, ``face``, ``surface``, ``area`` (m2), ``net_flux`` (W/m2), ``temperature`` (K), ``incident_flux`` and
        ``radiosity`` (W/m2) with errors (``net_flux_error``, …), and in scenes with sunlight ``absorbed_sunlight`` (W). In light mode each band has its columns
        (``net_flux_0``, ``net_flux_0_error``, …). Faces without patches have NaN. Errors are those of the exchange; the error of the finite zones is known by surface
        (:attr:`table`).
        """
        units = ("_W_m2", "_m2", "_K", "_W")
        columns: dict[str, Any] = {}
        for name, values in self._native.face_table().items():
            unit = next((u for u in units if name.endswith(u)), "")
            columns[name.removesuffix(unit)] = values
        return columns

    @property
    def zone_table(self) -> dict[str, Any]:
        """Results by zone as columns, for ``pandas.DataFrame(solution.zone_table)``; fields of several bands have a column for each.

        Errors are those of the exchange; the error of the finite zones is known by name (:attr:`table`).
        """
        names = np.asarray(self.names, dtype=object)
        kinds = np.asarray(["patch", "voxel", "pane"], dtype=object)
        columns: dict[str, Any] = {
            "name": names[self.name_index],
            "kind": kinds[self.array("kind")],
            "size": self.size,
        }
        for k, axis in enumerate("xyz"):
            columns[axis] = self.centre[:, k]
        bands = self.bands
        for field in ("radiosity", "incident", "error", "direct", "direct_error"):
            values = self.array(field)
            for b, band in enumerate(bands):
                if len(values):
                    columns[field if len(bands) == 1 else f"{field}_{band}"] = values[:, b]
        if self._native.is_thermal:
            for field in ("temperature", "temperature_error", "net", "net_error"):
                columns[field.replace("net", "net_flux")] = self.array(field)
        return columns

    @property
    def report(self) -> dict[str, Any]:
        """The report of the solve, as ``zonal solve --json``: engine, status, energy balance, errors, warnings."""
        report: dict[str, Any] = json.loads(self._native.report)
        return report

    @property
    def warnings(self) -> list[Diagnostic]:
        """Warnings of the solve and of its discretization error: a stated number may be wrong, or an error is unknown or exceeds the tolerance."""
        return of_rows(self._native.diagnostics, "warning")

    @property
    def notes(self) -> list[Diagnostic]:
        """Notes of the solve and of its discretization error: the stated numbers are valid."""
        return of_rows(self._native.diagnostics, "note")

    # Files.

    def save(self, path: Path) -> None:
        """Writes the solution (``.npz``), as ``zonal solve`` does.

        Raises
        ------
        FileError
            If the file cannot be written.
        """
        self._native.write(os.fspath(path))

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_bytes, (self._native.to_bytes(),)

    def export(
        self,
        path: Path,
        *,
        faces: bool = False,
        colours: Literal["radiosity", "irradiance"] | None = None,
        curve: Literal["filmic", "linear"] | None = None,
        stops: float | None = None,
        finest: float | None = None,
        vertices: int | None = None,
        light_groups: bool = False,
        lightmap: bool = False,
        texel: float | None = None,
        atlas: int | None = None,
        points: bool = False,
        irradiance_volume: bool = False,
        grid: Sequence[int] | None = None,
        rays: int | None = None,
        first_band: int | None = None,
        threads: int | None = None,
        progress: Progress = None,
    ) -> list[str]:
        """Writes the solution for other programs, as ``zonal export``.

        Parameters
        ----------
        path : path
            ``.csv`` (zones), ``.html`` (the viewer with its data), ``.glb`` (light in vertex colours), ``.vtu`` (patches and panes), ``.vti`` (medium).
        faces : bool
            Results by face of the meshes in place of zones (``.csv``, ``.npy``, ``.vtu``).
        colours, curve, stops, finest, vertices, light_groups : optional
            Settings of ``.glb``: quantity, tone curve, exposure in stops, smallest halved edge in m, largest number of vertices, light by group as attributes.
        lightmap, texel, atlas : optional
            ``.glb`` with the irradiance as a texture beside it, ``NAME.lightmap.exr``, in place of vertex colours; edge of its texels in m, largest side in texels.
        points : bool
            ``.vtu`` with radiosity and irradiance at the corners of patches and panes too.
        irradiance_volume, grid, rays : optional
            The incident radiance on a grid in spherical harmonics (``.npz``, ``.json`` with ``NAME.bin``); points along x, y, z, and rays of each point.
        first_band : int, optional
            ``.html``, ``.glb`` and irradiance volume of bands that are no colours: the first of the three that stand for red, green and blue; 0, 3, 6, ….
        threads, progress : optional
            As of :meth:`Scene.solve`.

        Returns
        -------
        list of str
            The written files.

        Raises
        ------
        InputError
            If the format lacks a part of the solution, a setting does not apply, or a file cannot be written.
        """
        settings = {"output": os.fspath(path), "colours": colours, "curve": curve, "stops": stops, "finest": finest}
        settings |= {"vertices": vertices, "first_band": first_band, "faces": faces, "light_groups": light_groups}
        settings |= {"lightmap": lightmap, "texel": texel, "atlas": atlas, "points": points, "irradiance_volume": irradiance_volume}
        settings |= {"grid": None if grid is None else [int(n) for n in grid], "rays": rays}
        with observed(progress) as function:
            return [str(p) for p in self._native.export(settings, function, threads)]

    # Light groups.

    @property
    def light_groups(self) -> list[str]:
        """Names of the lights that were solved separately."""
        return self._native.light_groups

    def group(self, name: str) -> dict[str, Floats]:
        """The part of a light group in ``incident``, ``error``, ``direct`` and ``direct_error``, (zones, bands) each, W/m2.

        Raises
        ------
        InputError
            If there is no such group.
        """
        if name not in self.light_groups:
            known = ", ".join(self.light_groups) or "none"
            raise InputError(f"group: there is no light group '{name}'; the groups are: {known}")
        return {field: self._native.group_array(name, field) for field in ("incident", "error", "direct", "direct_error")}

    def relight(
        self,
        lights: Mapping[str, Bands] | None = None,
        *,
        reflectance: Mapping[str, Bands] | None = None,
        albedo: Bands | None = None,
        kept_factors: Path | None = None,
        max_memory: float = 12.0,
        threads: int | None = None,
        progress: Progress = None,
        **factors: Bands,
    ) -> Solution:
        """Scales light groups, for which no equation is solved; other reflectances and albedos are solved with kept exchange factors.

        Parameters
        ----------
        lights : dict, optional
            Factors from 0 by light group: a number, or a list of three for red, green and blue.
        reflectance : dict, optional
            Reflectances by surface, 0 to 1: a number, or a list of three. A name stands for all that begin with it and a dot, as in :meth:`zones_of`.
        albedo : number or list of three, optional
            Albedo of the medium, 0 to 1.
        kept_factors : path, optional
            The folder ``keep_factors`` of :meth:`Scene.solve`, for ``reflectance`` and ``albedo``. It stays as it is.
        max_memory : float
            Memory limit of that solve, GB.
        threads, progress : optional
            As of :meth:`Scene.solve`.
        **factors : bands
            Factors by light group as keywords; groups with the name of a parameter are given in ``lights``.

        Returns
        -------
        Solution

        Raises
        ------
        InputError
            If there is no light group or surface of a name, a value is out of range, or the folder lacks the factors of this solution.

        Examples
        --------
        >>> import zonal as zn
        >>> scene = zn.Scene()
        >>> scene.surface(room=([0, 0, 0], [1, 1, 1]), name="walls", patch_size=0.5)
        >>> scene.surface(rectangle=([0.4, 0.4, 0.9], [0, 0.2, 0], [0.2, 0, 0]), name="lamp", emission=100.0)
        >>> bright = scene.solve(engine="dense")
        >>> dim = bright.relight(lamp=0.5)
        >>> bool(abs(dim.radiosity - 0.5 * bright.radiosity).max() < 1e-9)
        True
        """
        given = {**(lights or {}), **factors}
        changes = {
            "lights": [(name, _three_bands(name, f)) for name, f in given.items()],
            "reflectances": [(name, _unit_bands(f"reflectance of '{name}'", x)) for name, x in (reflectance or {}).items()],
            "albedo": None if albedo is None else _unit_bands("albedo", albedo),
            "kept_factors": None if kept_factors is None else os.fspath(kept_factors),
            "memory_limit": memory_limit(max_memory),
        }
        with observed(progress) as function:
            return Solution(self._native.relight(changes, function, threads))

    # Pictures.

    def render(
        self,
        camera: str | Camera | None = None,
        size: tuple[int, int] = (640, 480),
        *,
        samples: int | None = None,
        gather: int = 0,
        aperture: float | None = None,
        focus: float | None = None,
        show: Quantity | None = None,
        slice: tuple[Literal["x", "y", "z"], float] | None = None,
        threads: int | None = None,
        progress: Progress = None,
    ) -> npt.NDArray[Any]:
        """Draws a picture of light, or the values of a quantity.

        Parameters
        ----------
        camera : str or Camera, optional
            A camera of the scene, ``"overview"``, or a new one; by default the first of the scene, or the overview.
        size : (width, height)
            Pixels.
        samples : int, optional
            Rays for each pixel, 1 to 4096; adaptive by default.
        gather : int
            Rays of the final gather from each visible point; 0 interpolates between patches.
        aperture, focus : float, optional
            Lens in place of that of the camera, m.
        show : {"temperature", "net_flux", "radiosity", "irradiance"}, optional
            A quantity in place of light.
        slice : (axis, coordinate), optional
            With ``show="temperature"``: the medium on a plane, such as ``("z", 1.0)``, m.
        threads, progress : optional
            As of :meth:`Scene.solve`.

        Returns
        -------
        ndarray
            Radiance, (height, width, 3) of float32, W/(m2 sr), row 0 on top; :func:`encode_png` turns it into a PNG. With ``show``: values,
            (height, width) of float64 in the unit of the quantity, NaN without a zone.

        Raises
        ------
        InputError
            If there is no such camera, or the solution lacks the quantity.
        """
        settings = _picture(size, samples or 0, gather, show, slice)
        with observed(progress) as function:
            return _zonal.render(self._native, self._camera(camera, aperture, focus), settings, function, threads)

    def save_picture(
        self,
        path: Path,
        camera: str | None = None,
        size: tuple[int, int] = (640, 480),
        *,
        samples: int | None = None,
        gather: int = 0,
        aperture: float | None = None,
        focus: float | None = None,
        stops: float | None = None,
        contrast: float | None = None,
        bloom: float = 0.0,
        show: Quantity | None = None,
        range: tuple[float, float] | None = None,
        slice: tuple[Literal["x", "y", "z"], float] | None = None,
        log: bool = False,
        animate: Path | None = None,
        threads: int | None = None,
        progress: Progress = None,
    ) -> str:
        """Writes a picture, a picture in false colours with its scale, or the frames of a camera animation, as ``zonal render``.

        Parameters
        ----------
        path : path
            ``.png``, or ``.exr`` for linear values; with ``animate`` a folder.
        camera, size, samples, gather, aperture, focus, show, slice : optional
            As of :meth:`render`, with cameras of the scene alone.
        stops, contrast, bloom : float, optional
            Exposure relative to the automatic one, exponent of the luminance about middle grey, fraction of the light that the lens scatters.
        range : (low, high), optional
            With ``show``: the ends of the scale.
        log : bool
            With ``show``: a logarithmic scale.
        animate : path, optional
            Key frames (``.toml``).
        threads, progress : optional
            As of :meth:`Scene.solve`.

        Returns
        -------
        str
            The path.

        Raises
        ------
        InputError
            If a setting does not apply, the solution lacks the quantity, or the file cannot be written.
        """
        settings = _picture(size, samples, gather or None, show, slice)
        settings |= {"output": os.fspath(path), "camera": camera, "aperture": aperture, "focus": focus, "stops": stops, "contrast": contrast}
        settings |= {"bloom": bloom, "range": None if range is None else (float(range[0]), float(range[1])), "log": log}
        settings["animate"] = None if animate is None else os.fspath(animate)
        with observed(progress) as function:
            self._native.draw(settings, function, threads)
        return os.fspath(path)

    def _camera(self, camera: str | Camera | None, aperture: float | None, focus: float | None) -> dict[str, Any]:
        if isinstance(camera, Camera):
            view = tuple(tuple(float(x) for x in v) for v in (camera.origin, camera.target, camera.up))
            lens = (aperture if aperture is not None else camera.aperture, focus if focus is not None else camera.focus)
            return {"name": None, "view": view, "fov": camera.fov, "aperture": lens[0], "focus": lens[1]}
        return {"name": camera, "view": None, "fov": 60.0, "aperture": aperture, "focus": focus}

    def _preview(self, size: tuple[int, int] = (320, 240)) -> tuple[bytes, tuple[float, float] | None]:
        show: Quantity | None = "temperature" if self._native.is_thermal else None
        return _zonal.preview(self._native, self._camera(None, None, None), _picture(size, 0, 0, show, None))

    def _repr_html_(self) -> str:
        # Imported here: they are needed in notebooks alone, and take milliseconds.
        import base64
        import html

        report = self.report
        counts = f"{self.patch_count} patches, {self.voxel_count} voxel zones, {self.pane_count} pane zones"
        lines = [f"<b>{html.escape(self.name)}</b>", html.escape(counts), f"engine {html.escape(str(report.get('engine')))}"]
        picture = ""
        # Bands that are no colours have no picture.
        with contextlib.suppress(InputError):
            png, scale = self._preview()
            picture = f'<img alt="{html.escape(self.name)}" src="data:image/png;base64,{base64.b64encode(png).decode()}">'
            if scale is not None:
                lines.append(f"temperature {scale[0]:.5g} to {scale[1]:.5g} K")
        return f"<div>{picture}<br>{'<br>'.join(lines)}</div>"

    def __repr__(self) -> str:
        return f"<zonal.Solution {self.name!r}: {self.patch_count} patches, {self.voxel_count} voxel zones, {self.pane_count} pane zones>"

    # Other packages.

    def to_pyvista(self) -> Any:
        """The zones as a ``pyvista.MultiBlock``: ``surfaces`` and ``panes`` (PolyData), ``medium`` (ImageData), with the fields as cell data.

        A cell that walls divide into several zones has the mean over their volumes; a cell without a zone has NaN.
        """
        pv: Any = importlib.import_module("pyvista")
        blocks = pv.MultiBlock()
        corners, is_triangle = self.array("corners"), self.array("is_triangle").astype(bool)
        p, n = self.patch_count, self.zone_count
        for name, plates, zones in (("surfaces", slice(0, p), slice(0, p)), ("panes", slice(p, None), slice(n - self.pane_count, n))):
            if plates.stop == 0 or len(corners[plates]) == 0:
                continue
            mesh = pv.PolyData.from_irregular_faces(*_polygons(corners[plates], is_triangle[plates]))
            for field, values in self._fields().items():
                mesh.cell_data[field] = values[zones]
            blocks[name] = mesh
        grid = self._native.grid
        if grid is not None:
            cells, low, high = grid
            image = pv.ImageData(
                dimensions=[c + 1 for c in cells], origin=low, spacing=[(b - a) / c for a, b, c in zip(low, high, cells, strict=True)]
            )
            for field, values in self.medium_arrays().items():
                flat = values.reshape(*cells, -1).transpose(2, 1, 0, 3).reshape(-1, values.size // math.prod(cells))
                image.cell_data[field] = flat[:, 0] if flat.shape[1] == 1 else flat
            blocks["medium"] = image
        return blocks

    def to_meshio(self) -> Any:
        """The patches as a ``meshio.Mesh`` of triangles and quads with the fields as cell data."""
        meshio: Any = importlib.import_module("meshio")

        corners = self.array("corners")[: self.patch_count]
        is_triangle = self.array("is_triangle")[: self.patch_count].astype(bool)
        points = corners.reshape(-1, 3)
        first = 4 * np.arange(self.patch_count)
        blocks: list[tuple[str, Integers]] = []
        chosen: list[npt.NDArray[np.bool_]] = []
        for kind, count, mask in (("triangle", 3, is_triangle), ("quad", 4, ~is_triangle)):
            if mask.any():
                blocks.append((kind, first[mask][:, None] + np.arange(count)))
                chosen.append(mask)
        data = {name: [values[: self.patch_count][mask] for mask in chosen] for name, values in self._fields().items()}
        return meshio.Mesh(points, blocks, cell_data=data)

    def to_xarray(self) -> Any:
        """The zones as an ``xarray.Dataset``: fields over ``zone`` and ``band``, and of a medium also over ``x``, ``y``, ``z`` with the prefix ``medium_``."""
        xarray: Any = importlib.import_module("xarray")
        data: dict[str, Any] = {}
        units = {"temperature": "K", "temperature_error": "K"}
        for name, values in self._fields().items():
            unit = units.get(name, "W/m2")
            data[name] = (("zone", "band")[: values.ndim], values, {"units": unit})
        data["size"] = (("zone",), self.size, {"units": "m2 or m3"})
        coords: dict[str, Any] = {
            "name": ("zone", np.asarray(self.names)[self.name_index]),
            "band": self.bands,
            "centre": (("zone", "axis"), self.centre, {"units": "m"}),
        }
        grid = self._native.grid
        if grid is not None:
            cells, low, high = grid
            for axis, a, b, c in zip("xyz", low, high, cells, strict=True):
                coords[axis] = ((axis,), a + (b - a) * (np.arange(c) + 0.5) / c, {"units": "m"})
            for name, values in self.medium_arrays().items():
                dims = ("x", "y", "z", "band")[: values.ndim]
                data[f"medium_{name}"] = (dims, values, {"units": units.get(name, "W/m2")})
        return xarray.Dataset(data, coords=coords, attrs={"name": self.name, "engine": self.report["engine"]})

    def medium_arrays(self) -> dict[str, Floats]:
        """The fields on the grid of the medium, (nx, ny, nz) or (nx, ny, nz, bands).

        A cell that walls divide into several zones has the mean over their volumes; a cell without a zone has NaN.

        Raises
        ------
        InputError
            If the scene has no medium.
        """
        grid = self._native.grid
        if grid is None:
            raise InputError("medium: the scene has none; add a medium")
        cells = grid[0]
        zones = slice(self.patch_count, self.patch_count + self.voxel_count)
        cell, volume = self.array("cell"), self.size[zones]
        total = np.bincount(cell, weights=volume, minlength=math.prod(cells))
        out: dict[str, Floats] = {}
        for name, values in self._fields().items():
            columns = values[zones].reshape(len(cell), -1)
            sums = [np.bincount(cell, weights=volume * column, minlength=math.prod(cells)) for column in columns.T]
            with np.errstate(invalid="ignore"):
                means = np.stack(sums, axis=-1) / total[:, None]
            out[name] = means.reshape(*cells, *values.shape[1:])
        return out

    def _fields(self) -> dict[str, Floats]:
        names = ["radiosity", "incident", "error", "direct", "direct_error"]
        fields = {name: self.array(name) for name in names}
        if self._native.is_thermal:
            fields |= {name.replace("net", "net_flux"): self.array(name) for name in ("temperature", "temperature_error", "net", "net_error")}
        return {name: values for name, values in fields.items() if len(values)}


def _picture(
    size: tuple[int, int], samples: int | None, gather: int | None, show: str | None, plane: tuple[str, float] | None
) -> dict[str, Any]:
    axis = None
    if plane is not None:
        if plane[0] not in ("x", "y", "z"):
            raise InputError(f"slice: there is no axis '{plane[0]}'; give x, y or z and a coordinate")
        axis = ("xyz".index(plane[0]), float(plane[1]))
    return {"size": (int(size[0]), int(size[1])), "samples": samples, "gather": gather, "show": show, "slice": axis}


def _polygons(corners: Floats, is_triangle: npt.NDArray[np.bool_]) -> tuple[Floats, list[list[int]]]:
    starts = 4 * np.arange(len(corners))
    counts = np.where(is_triangle, 3, 4)
    return corners.reshape(-1, 3), [list(range(a, a + k)) for a, k in zip(starts.tolist(), counts.tolist(), strict=True)]


def _unit_bands(name: str, value: Bands) -> tuple[float, float, float]:
    bands = _three_bands(name, value)
    if not all(0.0 <= x <= 1.0 for x in bands):
        raise InputError(f"{name}: {value} is out of range; give numbers from 0 to 1")
    return bands


def _three_bands(name: str, factor: Bands) -> tuple[float, float, float]:
    if isinstance(factor, (int, float)):
        return (float(factor), float(factor), float(factor))
    if isinstance(factor, Sequence) and len(factor) == 3:
        return (float(factor[0]), float(factor[1]), float(factor[2]))
    raise InputError(f"relight: the value of {name} is neither a number nor a list of three; give one of them")


def zones_of(name: str, names: list[str], name_index: Integers) -> Integers:
    """The zones of a name, or of all names that begin with it and a dot or a slash."""
    chosen = [k for k, n in enumerate(names) if n == name or n.startswith((name + ".", name + "/"))]
    if not chosen:
        raise InputError(f"there is no '{name}'; the names are: {', '.join(names[:24])}")
    return np.flatnonzero(np.isin(name_index, chosen)).astype(np.int64)


def _from_bytes(data: bytes) -> Solution:
    return Solution(_zonal.Solution.from_bytes(data))


def load_solution(path: Path) -> Solution:
    """Reads a solution that :meth:`Solution.save` or ``zonal solve`` wrote.

    Parameters
    ----------
    path : path
        Solution (``.npz``).

    Returns
    -------
    Solution

    Raises
    ------
    FileError
        If the file cannot be read or is damaged.
    """
    return Solution(_zonal.Solution.read(os.fspath(path)))


def encode_png(
    radiance: npt.NDArray[np.float32], *, exposure: float | None = None, stops: float = 0.0, contrast: float = 1.0
) -> bytes:
    """A picture as the bytes of a PNG, as ``zonal render`` writes it.

    Parameters
    ----------
    radiance : ndarray
        (height, width, 3), W/(m2 sr), from :meth:`Solution.render`.
    exposure : float, optional
        Factor of the radiance, (m2 sr)/W; automatic by default.
    stops : float
        Exposure relative to that, stops.
    contrast : float
        Exponent of the luminance about middle grey.

    Returns
    -------
    bytes
    """
    return _zonal.encode_png(np.ascontiguousarray(radiance, dtype=np.float32), exposure, stops, contrast)
