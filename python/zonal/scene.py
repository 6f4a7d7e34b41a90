"""Scenes: from files, and from arrays in memory."""

from __future__ import annotations

import copy
import difflib
import json
import os
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path as _Path
from typing import Any, Literal, cast

import numpy as np

from . import _zonal
from ._document import Arrays, Writer, is_labelled, moved, renamed, save_arrays, toml_text
from ._progress import Progress, observed
from ._types import (
    Bands,
    Boundary,
    BoundaryEnd,
    Closure,
    Engine,
    Factors,
    FaceValues,
    LightGroups,
    Mesh,
    OpenSides,
    PatchRule,
    Path,
    Sides,
    Vector,
    VoxelValues,
    ZoneBasis,
)
from .dataset import Dataset, Distribution, distribution, load_dataset
from .errors import FileError, InputError
from .exchange import ExchangeAreas
from .solution import Solution, memory_limit
from .tools import keys as known_keys

__all__ = ["Scene", "load_scene"]


def _given(**keys: Any) -> dict[str, Any]:
    """The keys that are given."""
    return {name: value for name, value in keys.items() if value is not None}


def _further(table: str, keys: Mapping[str, Any]) -> dict[str, Any]:
    """Keys of a table of scene files that a method does not list."""
    known = {name for key in known_keys(table + ".") if "." not in (name := key.path.removeprefix(table + "."))}
    for name in keys:
        if name not in known:
            hint = difflib.get_close_matches(name, known, 1)
            raise TypeError(f"unexpected argument {name!r}" + (f"; did you mean {hint[0]!r}?" if hint else "; zonal.keys() lists the keys"))
    return dict(keys)


def _equal(a: Any, b: Any) -> bool:
    """True for equal documents; an array equals itself alone."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return a is b
    if type(a) is not type(b):
        return False
    if isinstance(a, dict):
        table, other = cast("dict[str, Any]", a), cast("dict[str, Any]", b)
        return table.keys() == other.keys() and all(_equal(table[k], other[k]) for k in table)
    if isinstance(a, list):
        items, others = cast("list[Any]", a), cast("list[Any]", b)
        return len(items) == len(others) and all(map(_equal, items, others))
    return bool(a == b)


class Scene:
    """A scene: surfaces, panes, a medium on a voxel grid, lights, cameras and settings.

    A scene is a document with the keys of scene files (:func:`keys` lists them), in which arrays and meshes stand in place of files. The methods add to it and
    take every key of their table by its name, also keys that they do not list; :attr:`document` is the document itself, and may be edited. Everything is checked
    when the scene is solved, with the messages of the command.

    Parameters
    ----------
    name : str, optional
        Name of the scene.
    mode : {"light", "thermal"}
        Radiation from given sources, or temperatures and heat.
    bands : int or list of [float, float], optional
        Number of bands, 1 to 128, or the limits of their wavelengths in nm; red, green and blue by default.

    Examples
    --------
    The wall fluxes of a furnace of 2 x 2 x 4 m with a heat source of 5 kW/m3 in the gas:

    >>> import zonal as zn
    >>> furnace = zn.Scene("furnace", mode="thermal")
    >>> furnace.surface(
    ...     room=([0, 0, 0], [2, 2, 4]),
    ...     name="wall",
    ...     emissivity=0.7,
    ...     temperature=900,
    ...     faces={"z0": {"emissivity": 0.85, "temperature": 1200}, "z1": {"temperature": 400}},
    ... )
    >>> furnace.medium([0, 0, 0], [2, 2, 4], cells=[4, 4, 8], extinction=0.5, heat_source=5000)
    >>> solution = furnace.solve(tolerance=1e-3)
    >>> dict(zip(solution.table["name"], solution.table["net_power"].round(-2)))["wall.z0"]
    np.float64(...)
    """

    document: dict[str, Any]
    """The document: a dictionary with the keys of scene files."""

    def __init__(
        self,
        name: str | None = None,
        *,
        mode: str | None = None,
        bands: int | Sequence[Sequence[float]] | None = None,
    ) -> None:
        self.document = _given(name=name, mode=mode, bands=bands)
        self._path: _Path | None = None
        self._original: dict[str, Any] | None = None
        self._region_of_extinction: dict[str, Any] | None = None

    # Reading and writing.

    @classmethod
    def _load(cls, path: Path) -> Scene:
        import tomllib

        scene = cls()
        scene._path = _Path(path)
        try:
            with open(path, "rb") as file:
                scene.document = tomllib.load(file)
        except (tomllib.TOMLDecodeError, UnicodeDecodeError, OSError):
            # The native reader states the place and the remedy.
            _zonal.Scene.read(os.fspath(path))
            raise
        scene._original = copy.deepcopy(scene.document)
        return scene

    def _text_and_arrays(self) -> tuple[str, Arrays]:
        writer = Writer()
        return toml_text(writer.plain(self.document, "", "")), writer.arrays

    def _native(self, threads: int | None) -> _zonal.Scene:
        if self._path is not None and _equal(self.document, self._original):
            return _zonal.Scene.read(os.fspath(self._path), threads)
        text, arrays = self._text_and_arrays()
        base, name = ("", "scene") if self._path is None else (str(self._path.parent), self._path.stem)
        values = {name: value if isinstance(value, np.ndarray) else tuple(value) for name, value in arrays.values.items()}
        try:
            return _zonal.Scene.parse(text, base, values, name, threads)
        except InputError as error:
            raise self._by_argument(error) from None

    def _by_argument(self, error: InputError) -> InputError:
        """The error with the argument `extinction` of the medium in place of the region that an array became."""
        regions = self.document.get("medium", {}).get("region") or [None]
        region, key = "medium.region[0].density", error.key or ""
        if regions[0] is not self._region_of_extinction or not key.startswith(region):
            return error
        key = key.replace(region, "medium.extinction")
        return InputError(error.message.replace(region, "medium.extinction"), error.file, key, key)

    def to_toml(self) -> str:
        """The text of the scene file.

        Arrays stand in it as the names of the files that :meth:`save` writes beside a file ``scene.toml``.

        Examples
        --------
        >>> import zonal as zn
        >>> scene = zn.Scene("box")
        >>> scene.surface(box=([0, 0, 0], [1, 1, 1]), reflectance=0.5)
        >>> print(scene.to_toml())
        name = "box"
        <BLANKLINE>
        [[surface]]
        reflectance = 0.5
        box = { min = [0, 0, 0], max = [1, 1, 1] }
        <BLANKLINE>
        """
        writer = Writer()
        values = writer.plain(self.document, "", "")
        names = {
            name: f"scene.{'array' if isinstance(array, np.ndarray) else 'mesh'}-{k}.{'npy' if isinstance(array, np.ndarray) else 'obj'}"
            for k, (name, array) in enumerate(writer.arrays.values.items(), start=1)
        }
        return toml_text(renamed(values, names))

    def save(self, path: Path) -> None:
        """Writes a scene file, and its arrays and meshes beside it (``NAME.array-1.npy``, ``NAME.mesh-2.obj``).

        ``zonal solve`` of the file gives the bits of :meth:`solve`.

        Parameters
        ----------
        path : path
            Scene file to write (``.toml``).

        Raises
        ------
        FileError
            If a file cannot be written.
        """
        target = _Path(path)
        writer = Writer()
        values = writer.plain(self.document, "", "")
        if self._path is not None and self._path.parent.resolve() != target.parent.resolve():
            values = moved(values, self._path.parent, writer.arrays)
        values.setdefault("name", self._path.stem if self._path is not None else "scene")
        try:
            values = save_arrays(values, writer.arrays, target.parent, target.stem)
            temporary = target.with_name(target.name + ".partial")
            temporary.write_text(toml_text(values), encoding="utf-8")
            temporary.replace(target)
        except OSError as e:
            raise FileError(f"{target}: the scene cannot be written ({e}); choose another folder", str(target)) from e

    def __repr__(self) -> str:
        counts = [f"{len(self.document.get(k, []))} {k}(s)" for k in ("surface", "pane", "light", "node") if self.document.get(k)]
        medium = ["medium"] if "medium" in self.document else []
        return f"<zonal.Scene {self.document.get('name', '')!r}: {', '.join(counts + medium) or 'empty'}>"

    # Parts.

    def _add(self, key: str, table: dict[str, Any]) -> None:
        self.document.setdefault(key, []).append(table)

    def surface(
        self,
        mesh: Mesh | None = None,
        *,
        name: str | None = None,
        room: tuple[Vector, Vector] | None = None,
        box: tuple[Vector, Vector] | None = None,
        rectangle: tuple[Vector, Vector, Vector] | None = None,
        triangle: Sequence[Vector] | None = None,
        reflectance: FaceValues | None = None,
        emissivity: FaceValues | None = None,
        transmittance: Bands | None = None,
        emission: FaceValues | None = None,
        temperature: FaceValues | None = None,
        heat_flux: FaceValues | None = None,
        net_power: FaceValues | None = None,
        node: str | None = None,
        heat_transfer_coefficient: float | None = None,
        ambient_temperature: float | None = None,
        solar_absorptance: float | None = None,
        sides: Sides | None = None,
        back: Mapping[str, Any] | None = None,
        patch_size: float | None = None,
        texture: Path | None = None,
        faces: Mapping[str, Mapping[str, Any]] | None = None,
        omit: Sequence[str] | None = None,
        materials: Mapping[str, Mapping[str, Any]] | None = None,
        solid: bool | None = None,
        open_sides: OpenSides | None = None,
        lights: bool | None = None,
        scale: float | None = None,
        translate: Vector | None = None,
        rotate_degrees: Vector | None = None,
        normals: Literal["file", "flat"] | None = None,
        rotate_z_degrees: float | None = None,
        **keys: Any,
    ) -> None:
        """Adds a surface: a mesh or one of the shapes.

        Parameters
        ----------
        mesh : mesh or path, optional
            ``(vertices, faces)`` with arrays of shape (vertices, 3) and (faces, 3) or (faces, 4), counter-clockwise seen from the front;
            ``pyvista.PolyData``, ``trimesh.Trimesh`` or ``meshio.Mesh``; or the path of a mesh file. Physical groups of gmsh are its materials.
        name : str, optional
            Unique name; ``surface1``, … by default.
        room, box : (min, max), optional
            Six walls that face inward, or a solid box; corners in m.
        rectangle : (origin, edge1, edge2), optional
            A parallelogram whose front faces edge1 x edge2; m.
        triangle : three points, optional
            A triangle whose front sees the corners counter-clockwise; m.
        reflectance, emissivity : bands or array
            Diffuse reflectance, or emissivity in its place, 0 to 1. An array of shape (faces,) has a value for each face of the mesh.
        transmittance : bands, optional
            Diffuse transmittance of a thin sheet, from each side to the other, 0 to 1; with the reflectance at most 1 (light mode).
        emission : bands or array
            Emitted flux, W/m2 (light mode).
        temperature, heat_flux, net_power : float or array
            Known temperature, K; net radiative flux that leaves the surface, W/m2; or net power of the whole surface, W (thermal mode).
        node : str, optional
            The node whose temperature the surface has (thermal mode).
        heat_transfer_coefficient, ambient_temperature : float, optional
            Convection, W/(m2 K), to air of this temperature, K (thermal mode).
        solar_absorptance : float, optional
            Absorbed fraction of sunlight (thermal mode with lights).
        sides : {"front", "both"}, optional
            Sides that take part in the exchange.
        back : dict, optional
            Emissivity and solar absorptance of the back, with both sides (thermal mode); as the front by default.
        patch_size : float, optional
            Target edge of a patch, m.
        texture : path, optional
            PNG or JPEG that multiplies the reflectance (light mode).
        faces : dict, optional
            Properties of single faces ``x0``, ``x1``, … of a box or room.
        omit : list of str, optional
            Walls that a room lacks.
        materials : dict, optional
            Properties of single materials of a mesh.
        solid : bool, optional
            Whether closed parts of a mesh are solids and rooms; true by default.
        open_sides : {"file", "both"}, optional
            Sides of the open parts of a mesh: those of its file (default), or both; then parts that are turned inside out count as open.
        lights : bool, optional
            Whether the lights of a glTF mesh become lights of the scene (light mode); true by default.
        scale, translate, rotate_degrees : optional
            Placement of a mesh: factor of lengths, then rotations about x, y and z, then a translation in m.
        normals : {"file", "flat"}, optional
            Shading of pictures by the vertex normals and normal maps of a mesh file, or of flat faces; by the file by default.
        rotate_z_degrees : float, optional
            Rotation of a box about the vertical through its centre.

        Examples
        --------
        >>> import numpy as np, zonal as zn
        >>> vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
        >>> scene = zn.Scene(mode="thermal")
        >>> scene.surface((vertices, [[0, 1, 2, 3]]), name="plate", emissivity=0.9, temperature=np.array([400.0]))
        >>> scene
        <zonal.Scene '': 1 surface(s)>
        """
        table = _given(
            name=name,
            reflectance=reflectance,
            emissivity=emissivity,
            transmittance=transmittance,
            emission=emission,
            temperature=temperature,
            heat_flux=heat_flux,
            net_power=net_power,
            node=node,
            heat_transfer_coefficient=heat_transfer_coefficient,
            ambient_temperature=ambient_temperature,
            solar_absorptance=solar_absorptance,
            sides=sides,
            back=back,
            patch_size=patch_size,
            texture=texture,
            faces=faces,
            omit=omit,
            materials=materials,
            solid=solid,
            open_sides=open_sides,
            lights=lights,
            **_further("surface[]", keys),
        )
        if mesh is not None:
            table["mesh"] = _placed_mesh(mesh, scale, translate, rotate_degrees) | _given(normals=normals)
        if room is not None:
            table["room"] = {"min": room[0], "max": room[1]}
        if box is not None:
            table["box"] = {"min": box[0], "max": box[1], "rotate_z_degrees": rotate_z_degrees}
        if rectangle is not None:
            table["rectangle"] = {"origin": rectangle[0], "edge1": rectangle[1], "edge2": rectangle[2]}
        if triangle is not None:
            table["triangle"] = {"corners": triangle}
        self._add("surface", table)

    def pane(
        self,
        polygon: Sequence[Vector] | Any,
        *,
        thickness: float,
        extinction: Bands | None = None,
        name: str | None = None,
        albedo: Bands | None = None,
        absorption: Bands | None = None,
        emission: Bands | None = None,
        temperature: float | None = None,
        heat_source: float | None = None,
        solar_extinction: float | None = None,
        solar_albedo: float | None = None,
        **keys: Any,
    ) -> None:
        """Adds a pane: a thin sheet that absorbs and scatters.

        Parameters
        ----------
        polygon : list of points or array of shape (corners, 3)
            Corners in order, plane and convex, m.
        thickness : float
            Thickness, m.
        extinction, absorption : bands
            Extinction coefficient, or extinction x (1 - albedo) in its place, 1/m.
        albedo : bands, optional
            Scattering albedo, 0 to 1.
        emission : bands, optional
            Black emissive power, W/m2 (light mode).
        temperature : float, optional
            Known temperature, K (thermal mode); without one the pane is in radiative equilibrium, ``heat_source=0``.
        solar_extinction, solar_albedo : float, optional
            Values for sunlight (thermal mode with lights).
        """
        table = _given(
            name=name,
            polygon=polygon,
            thickness=thickness,
            extinction=extinction,
            albedo=albedo,
            absorption=absorption,
            emission=emission,
            temperature=temperature,
            heat_source=heat_source,
            solar_extinction=solar_extinction,
            solar_albedo=solar_albedo,
            **_further("pane[]", keys),
        )
        self._add("pane", table)

    def medium(
        self,
        min: Vector,
        max: Vector,
        *,
        cells: Sequence[int] | None = None,
        cell_size: float | Vector | None = None,
        extinction: VoxelValues | None = None,
        albedo: VoxelValues | None = None,
        absorption: Bands | None = None,
        emission: VoxelValues | None = None,
        source: Bands | None = None,
        temperature: VoxelValues | None = None,
        heat_source: VoxelValues | None = None,
        gas: Mapping[str, Any] | None = None,
        solar_extinction: float | None = None,
        solar_albedo: float | None = None,
        **keys: Any,
    ) -> None:
        """Sets the participating medium on a grid of voxels.

        An array of shape (nx, ny, nz) fills the whole box; an ``xarray.DataArray`` with coordinates of the centres of its cells fills their box. Arrays have any
        resolution: a voxel has the mean over its volume. They are read where they lie in memory, in single or double precision, in C or Fortran order.

        Parameters
        ----------
        min, max : point
            Corners of the grid, m.
        cells : [nx, ny, nz], optional
            Number of voxels; by default that of the first array.
        cell_size : float or vector, optional
            Edge of a voxel, m, in place of ``cells``.
        extinction : bands or array
            Extinction coefficient, 1/m. An array is a region with this density.
        albedo : bands or array, optional
            Scattering albedo, 0 to 1.
        absorption : bands, optional
            Extinction x (1 - albedo), 1/m, in place of one of them.
        emission : bands or array, optional
            Black emissive power, W/m2 (light mode).
        source : bands, optional
            Volumetric source, W/m3 (light mode).
        temperature, heat_source : float or array, optional
            Known temperature, K, or heat source, W/m3; 0 is radiative equilibrium (thermal mode).
        gas : dict, optional
            Gas model and composition, as from :func:`zonal.Gas`; fractions and pressure may be arrays (thermal mode).
        solar_extinction, solar_albedo : float, optional
            Values for sunlight (thermal mode with lights).

        Examples
        --------
        >>> import numpy as np, zonal as zn
        >>> smoke = np.random.default_rng(1).uniform(0.0, 0.2, (8, 8, 4))
        >>> scene = zn.Scene()
        >>> scene.medium([0, 0, 0], [4, 4, 2], extinction=smoke, albedo=0.9)
        >>> scene.document["medium"]["cells"]
        [8, 8, 4]
        """
        table = _given(
            min=min,
            max=max,
            cells=cells,
            cell_size=cell_size,
            albedo=albedo,
            absorption=absorption,
            emission=emission,
            source=source,
            temperature=temperature,
            heat_source=heat_source,
            gas=gas,
            solar_extinction=solar_extinction,
            solar_albedo=solar_albedo,
            **_further("medium", keys),
        )
        regions = self.document.get("medium", {}).get("region", [])
        if _is_grid(extinction):
            self._region_of_extinction = {"density": _density(extinction, min, max)}
            regions = [self._region_of_extinction, *regions]
        elif extinction is not None:
            table["extinction"] = extinction
        if cells is None and cell_size is None:
            in_gas = [] if gas is None else list(gas.values())
            shapes = [_shape(v) for v in (extinction, albedo, emission, temperature, heat_source, *in_gas) if _is_grid(v)]
            if shapes:
                table["cells"] = shapes[0]
        if regions:
            table["region"] = regions
        self.document["medium"] = table

    def region(
        self,
        *,
        box: tuple[Vector, Vector] | None = None,
        mesh: Mesh | None = None,
        density: VoxelValues | None = None,
        extinction: Bands | None = None,
        albedo: VoxelValues | None = None,
        absorption: Bands | None = None,
        emission: VoxelValues | None = None,
        source: Bands | None = None,
        temperature: VoxelValues | None = None,
        heat_source: VoxelValues | None = None,
        gas: Mapping[str, Any] | None = None,
        solar_extinction: float | None = None,
        solar_albedo: float | None = None,
        scale: float | None = None,
        translate: Vector | None = None,
        rotate_degrees: Vector | None = None,
        **keys: Any,
    ) -> None:
        """Adds a part of the medium with other properties, over those before it.

        Parameters
        ----------
        box : (min, max), optional
            A box; voxels that it cuts are mixed by volume; m.
        mesh : mesh or path, optional
            A closed mesh; voxels whose centre lies inside have the properties.
        density : array or dict, optional
            Extinction, 1/m: an array of shape (nx, ny, nz) that fills the medium, an ``xarray.DataArray``, or a table with ``file`` (an array or a path:
            ``.npy``, ``.vdb``, ``.vol``), ``min``, ``max``, ``scale``, ``interpolation``, and for OpenVDB ``grid``, ``unit``, ``translate``, ``rotate_degrees``, ``level_set``.
        extinction, albedo, absorption, emission, source, temperature, heat_source, gas, solar_extinction, solar_albedo : optional
            Properties, as of :meth:`medium`.
        scale, translate, rotate_degrees : optional
            Placement of the mesh.
        """
        table = _given(
            extinction=extinction,
            albedo=albedo,
            absorption=absorption,
            emission=emission,
            source=source,
            temperature=temperature,
            heat_source=heat_source,
            gas=gas,
            solar_extinction=solar_extinction,
            solar_albedo=solar_albedo,
            **_further("medium.region[]", keys),
        )
        if box is not None:
            table["box"] = {"min": box[0], "max": box[1]}
        if mesh is not None:
            table["mesh"] = _placed_mesh(mesh, scale, translate, rotate_degrees)
        medium = self.document.get("medium")
        if medium is None:
            raise InputError("medium.region: the scene has no medium; call medium(min, max, …) first", key="medium.region")
        if density is not None:
            table["density"] = _density(density, medium["min"], medium["max"]) if _is_grid(density) else density
        medium.setdefault("region", []).append(table)

    def sun(
        self,
        direction: Vector | None = None,
        irradiance: Bands | None = None,
        *,
        illuminance: float | None = None,
        angular_diameter: float | None = None,
        latitude: float | None = None,
        longitude: float | None = None,
        time: str | datetime | None = None,
        north: Vector | None = None,
        up: Vector | None = None,
        efficacy: float | None = None,
        tint: Bands | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> None:
        """Adds a distant light.

        Parameters
        ----------
        direction : vector, optional
            Direction in which the light travels.
        irradiance, illuminance : bands or float, optional
            Irradiance of a plane normal to the direction, W/m2, a number in thermal mode; or its illuminance, lx.
        angular_diameter : float, optional
            Degrees; 0.53 by default.
        latitude, longitude : float, optional
            Degrees, positive in the north and in the east, in place of the direction.
        time : str or datetime, optional
            Moment with its offset from universal time, such as ``"2026-06-21T12:00:00+02:00"``.
        north, up : vector, optional
            Directions towards north and towards the zenith; y and z by default.
        efficacy : float, optional
            Lumens of a watt of radiant power, with the illuminance; 683 by default.
        tint : bands, optional
            Relative power of the bands, of mean 1, with the illuminance.
        """
        table = _given(
            kind="sun",
            name=name,
            direction=direction,
            irradiance=irradiance,
            illuminance=illuminance,
            angular_diameter=angular_diameter,
            latitude=latitude,
            longitude=longitude,
            time=_moment(time),
            north=north,
            up=up,
            efficacy=efficacy,
            tint=tint,
            **_further("light[] (sun)", keys),
        )
        self._add("light", table)

    def sky(
        self,
        radiance: Bands | None = None,
        *,
        luminance: float | None = None,
        efficacy: float | None = None,
        tint: Bands | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> None:
        """Adds a uniform sky.

        Parameters
        ----------
        radiance, luminance : bands or float, optional
            Radiance, W/(m2 sr), a number in thermal mode; or luminance, cd/m2.
        efficacy, tint : optional
            Of the luminance, as of :meth:`sun`.
        """
        more = _further("light[] (sky)", keys)
        self._add("light", _given(kind="sky", name=name, radiance=radiance, luminance=luminance, efficacy=efficacy, tint=tint, **more))

    def cie_sky(
        self,
        type: int,
        *,
        horizontal_irradiance: Bands | None = None,
        zenith_radiance: Bands | None = None,
        horizontal_illuminance: float | None = None,
        zenith_luminance: float | None = None,
        direction: Vector | None = None,
        latitude: float | None = None,
        longitude: float | None = None,
        time: str | datetime | None = None,
        north: Vector | None = None,
        up: Vector | None = None,
        ground_reflectance: float | None = None,
        efficacy: float | None = None,
        tint: Bands | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> None:
        """Adds a CIE standard general sky (ISO 15469), without the sun.

        Parameters
        ----------
        type : int
            1 (overcast) to 15 (clear, turbid); 5 is uniform, 12 clear.
        horizontal_irradiance, zenith_radiance : bands, optional
            Irradiance of an unobstructed horizontal plane, W/m2, or radiance of the zenith, W/(m2 sr).
        horizontal_illuminance, zenith_luminance : float, optional
            The same in lx or cd/m2.
        direction : vector, optional
            Direction in which the light of the sun travels; types 1, 3 and 5 need none.
        latitude, longitude, time, north, up : optional
            Place and time in place of the direction, as of :meth:`sun`.
        ground_reflectance : float, optional
            Reflectance of the ground below the horizon, which the sky lights; 0 by default.
        efficacy, tint : optional
            Of photometric quantities, as of :meth:`sun`.
        """
        table = _given(
            kind="cie-sky",
            name=name,
            type=type,
            horizontal_irradiance=horizontal_irradiance,
            zenith_radiance=zenith_radiance,
            horizontal_illuminance=horizontal_illuminance,
            zenith_luminance=zenith_luminance,
            direction=direction,
            latitude=latitude,
            longitude=longitude,
            time=_moment(time),
            north=north,
            up=up,
            ground_reflectance=ground_reflectance,
            efficacy=efficacy,
            tint=tint,
            **_further("light[] (cie-sky)", keys),
        )
        self._add("light", table)

    def perez_sky(
        self,
        direct_normal: float,
        diffuse_horizontal: float,
        *,
        direction: Vector | None = None,
        latitude: float | None = None,
        longitude: float | None = None,
        time: str | datetime | None = None,
        north: Vector | None = None,
        up: Vector | None = None,
        ground_reflectance: float | None = None,
        tint: Bands | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> None:
        """Adds a Perez all-weather sky, without the sun.

        Parameters
        ----------
        direct_normal, diffuse_horizontal : float
            Irradiance by the sun of a plane normal to its light, and by the sky of a horizontal plane, W/m2.
        direction : vector, optional
            Direction in which the light of the sun travels.
        latitude, longitude, time, north, up : optional
            Place and time in place of the direction, as of :meth:`sun`.
        ground_reflectance : float, optional
            Reflectance of the ground below the horizon, which the sky lights; 0 by default.
        tint : bands, optional
            Relative power of the bands, of mean 1.
        """
        table = _given(
            kind="perez-sky",
            name=name,
            direct_normal=direct_normal,
            diffuse_horizontal=diffuse_horizontal,
            direction=direction,
            latitude=latitude,
            longitude=longitude,
            time=_moment(time),
            north=north,
            up=up,
            ground_reflectance=ground_reflectance,
            tint=tint,
            **_further("light[] (perez-sky)", keys),
        )
        self._add("light", table)

    def image_sky(
        self,
        image: str | os.PathLike[str],
        *,
        radiance: Bands | None = None,
        luminance: float | None = None,
        up: Vector | None = None,
        rotation: float | None = None,
        efficacy: float | None = None,
        tint: Bands | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> None:
        """Adds a sky from an equirectangular picture.

        Parameters
        ----------
        image : str or path
            ``.exr`` (OpenEXR) or ``.hdr`` (Radiance), twice as wide as high.
        radiance, luminance : bands or float, optional
            Radiance, W/(m2 sr), or luminance, cd/m2, of the pixel value 1; a radiance of 1 by default.
        up : vector, optional
            Direction of the upper edge of the picture; z by default.
        rotation : float, optional
            Degrees about ``up``, counterclockwise as seen from above; at 0 the middle of the picture looks along x.
        efficacy, tint : optional
            Of the luminance, as of :meth:`sun`.
        """
        table = _given(
            kind="image-sky",
            name=name,
            image=os.fspath(image),
            radiance=radiance,
            luminance=luminance,
            up=up,
            rotation=rotation,
            efficacy=efficacy,
            tint=tint,
            **_further("light[] (image-sky)", keys),
        )
        self._add("light", table)

    def emitter(self, surface: str, *, name: str | None = None) -> None:
        """Makes the emission of a named surface direct light, for small lamps."""
        self._add("light", _given(kind="emitter", name=name, surface=surface))

    def planet(
        self,
        direction: Vector,
        angular_diameter: float,
        *,
        name: str | None = None,
        temperature: float | None = None,
        infrared_flux: float | None = None,
        reflected_flux: float | None = None,
        **keys: Any,
    ) -> None:
        """Adds a distant disc that emits and reflects uniformly (thermal mode).

        Parameters
        ----------
        direction : vector
            Direction in which its radiation travels.
        angular_diameter : float
            Degrees, above 0 and below 180.
        temperature, infrared_flux : float, optional
            Black-body temperature, K, or infrared flux at its surface, W/m2.
        reflected_flux : float, optional
            Flux of reflected sunlight at its surface, W/m2.
        """
        table = _given(
            kind="planet",
            name=name,
            direction=direction,
            angular_diameter=angular_diameter,
            temperature=temperature,
            infrared_flux=infrared_flux,
            reflected_flux=reflected_flux,
            **_further("light[] (planet)", keys),
        )
        self._add("light", table)

    def point(
        self,
        position: Vector,
        *,
        intensity: Bands | None = None,
        power: Bands | None = None,
        luminous_intensity: float | None = None,
        luminous_flux: float | None = None,
        efficacy: float | None = None,
        tint: Bands | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> None:
        """Adds a light without extent, the same in all directions.

        Parameters
        ----------
        position : vector
            Position, m.
        intensity, power : bands, optional
            Radiant intensity, W/sr, or radiant power, W; a number in thermal mode.
        luminous_intensity, luminous_flux : float, optional
            The same in cd or lm.
        efficacy, tint : optional
            Of photometric quantities, as of :meth:`sun`.
        """
        table = _given(
            kind="point",
            name=name,
            position=position,
            intensity=intensity,
            power=power,
            luminous_intensity=luminous_intensity,
            luminous_flux=luminous_flux,
            efficacy=efficacy,
            tint=tint,
            **_further("light[] (point)", keys),
        )
        self._add("light", table)

    def spot(
        self,
        position: Vector,
        direction: Vector,
        outer_angle: float,
        *,
        inner_angle: float | None = None,
        intensity: Bands | None = None,
        power: Bands | None = None,
        luminous_intensity: float | None = None,
        luminous_flux: float | None = None,
        efficacy: float | None = None,
        tint: Bands | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> None:
        """Adds a light without extent that fills a cone.

        Parameters
        ----------
        position : vector
            Position, m.
        direction : vector
            Axis of the cone, the way along which light travels.
        outer_angle : float
            Degrees between the axis and the edge of the cone, where the intensity has fallen to 0.
        inner_angle : float, optional
            Degrees between the axis and the directions up to which the intensity is full; 0 by default.
        intensity, power : bands, optional
            Radiant intensity on the axis, W/sr, or radiant power, W; a number in thermal mode.
        luminous_intensity, luminous_flux : float, optional
            The same in cd or lm.
        efficacy, tint : optional
            Of photometric quantities, as of :meth:`sun`.
        """
        table = _given(
            kind="spot",
            name=name,
            position=position,
            direction=direction,
            inner_angle=inner_angle,
            outer_angle=outer_angle,
            intensity=intensity,
            power=power,
            luminous_intensity=luminous_intensity,
            luminous_flux=luminous_flux,
            efficacy=efficacy,
            tint=tint,
            **_further("light[] (spot)", keys),
        )
        self._add("light", table)

    def tube(
        self,
        start: Vector,
        end: Vector,
        radius: float,
        *,
        power: Bands | None = None,
        luminous_flux: float | None = None,
        reflectance: Bands | None = None,
        efficacy: float | None = None,
        tint: Bands | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> None:
        """Adds a cylinder that emits diffusely (light mode), a surface of its own.

        Parameters
        ----------
        start, end : vector
            Ends of the axis, m.
        radius : float
            Radius, m.
        power, luminous_flux : bands or float, optional
            Radiant power, W, or luminous flux, lm.
        reflectance : bands, optional
            Diffuse reflectance of the tube; 0.5 by default.
        efficacy, tint : optional
            Of the luminous flux, as of :meth:`sun`.
        """
        table = _given(
            kind="tube",
            name=name,
            start=start,
            end=end,
            radius=radius,
            power=power,
            luminous_flux=luminous_flux,
            reflectance=reflectance,
            efficacy=efficacy,
            tint=tint,
            **_further("light[] (tube)", keys),
        )
        self._add("light", table)

    def luminaire(
        self,
        file: str | os.PathLike[str],
        position: Vector,
        *,
        direction: Vector | None = None,
        rotation: float | None = None,
        dimming: float | None = None,
        efficacy: float | None = None,
        tint: Bands | None = None,
        name: str | None = None,
        **keys: Any,
    ) -> None:
        """Adds a light without extent with the intensities of a photometric file.

        Parameters
        ----------
        file : str or path
            ``.ies`` (IES LM-63) or ``.ldt`` (EULUMDAT).
        position : vector
            Position, m.
        direction : vector, optional
            Direction of the angle 0 of the file; straight down by default.
        rotation : float, optional
            Degrees about the direction, from the plane C = 0 towards C = 90.
        dimming : float, optional
            Factor of the intensities.
        efficacy : float, optional
            Lumens of a watt of radiant power; 683 by default.
        tint : bands, optional
            Relative power of the bands, of mean 1.
        """
        table = _given(
            kind="luminaire",
            name=name,
            file=os.fspath(file),
            position=position,
            direction=direction,
            rotation=rotation,
            dimming=dimming,
            efficacy=efficacy,
            tint=tint,
            **_further("light[] (luminaire)", keys),
        )
        self._add("light", table)

    def node(
        self,
        name: str,
        *,
        temperature: float | None = None,
        net_power: float | None = None,
        links: Sequence[Mapping[str, Any]] | None = None,
        **keys: Any,
    ) -> None:
        """Adds a body at one temperature (thermal mode).

        Parameters
        ----------
        name : str
            Name to which surfaces and links refer.
        temperature : float, optional
            Known temperature, K.
        net_power : float, optional
            Power supplied to a node of unknown temperature, W.
        links : list of dict, optional
            Heat paths to other nodes: ``to`` and one of ``conductance`` (W/K), ``conductance_per_area`` (W/(m2 K)), ``effective_emissivity``.
        """
        self._add("node", _given(name=name, temperature=temperature, net_power=net_power, links=links, **_further("node[]", keys)))

    def surroundings(
        self, *, radiance: Bands | None = None, temperature: float | None = None, name: str | None = None, **keys: Any
    ) -> None:
        """Sets what enters from beyond the scene: a radiance, W/(m2 sr) (light mode), or a temperature, K (thermal mode)."""
        self.document["surroundings"] = _given(radiance=radiance, temperature=temperature, name=name, **_further("surroundings", keys))

    def boundary(
        self,
        *,
        x: Boundary | None = None,
        y: Boundary | None = None,
        z: Boundary | None = None,
        x0: BoundaryEnd | None = None,
        x1: BoundaryEnd | None = None,
        y0: BoundaryEnd | None = None,
        y1: BoundaryEnd | None = None,
        z0: BoundaryEnd | None = None,
        z1: BoundaryEnd | None = None,
        min: Vector | None = None,
        max: Vector | None = None,
        **keys: Any,
    ) -> None:
        """Sets periodic axes and symmetry planes.

        Parameters
        ----------
        x, y, z : {"symmetry", "periodic", "scene"}, optional
            Both ends of an axis.
        x0, x1, y0, y1, z0, z1 : {"symmetry", "scene"}, optional
            One end of an axis.
        min, max : point, optional
            Corners of the boundary of a scene without a medium, m.
        """
        more = _further("boundary", keys)
        self.document["boundary"] = _given(x=x, y=y, z=z, x0=x0, x1=x1, y0=y0, y1=y1, z0=z0, z1=z1, min=min, max=max, **more)

    def thermal(
        self,
        *,
        band_fractions: Sequence[float] | None = None,
        weights: Sequence[Sequence[float] | str] | None = None,
        range: Sequence[float] | None = None,
        allow_partial: bool | None = None,
        **keys: Any,
    ) -> None:
        """Sets the fractions of the black-body emission in the bands (thermal mode).

        Parameters
        ----------
        band_fractions : list of float, optional
            Constant fractions; they sum to 1.
        weights : list of lists, optional
            Polynomials in the temperature by ascending power, 1/K^n; ``"rest"`` for one of them.
        range : [float, float], optional
            Temperatures for which the polynomials hold, K.
        allow_partial : bool, optional
            Accepts fractions that sum to less than 1.
        """
        self.document["mode"] = "thermal"
        self.document["thermal"] = _given(
            band_fractions=band_fractions,
            weights=weights,
            range=range,
            allow_partial=allow_partial,
            **_further("thermal", keys),
        )

    def camera(
        self,
        origin: Vector,
        target: Vector,
        *,
        name: str | None = None,
        up: Vector | None = None,
        fov: float | None = None,
        aperture: float | None = None,
        focus: float | None = None,
        **keys: Any,
    ) -> None:
        """Adds a camera.

        Parameters
        ----------
        origin, target : point
            Position, and the point in the middle of the picture, m.
        up : vector, optional
            Upward direction; z by default.
        fov : float, optional
            Angle of view across the picture's width, degrees; 60 by default.
        aperture, focus : float, optional
            Diameter of the lens and distance in focus, m.
        """
        more = _further("camera[]", keys)
        self._add("camera", _given(name=name, origin=origin, target=target, up=up, fov=fov, aperture=aperture, focus=focus, **more))

    def settings(
        self,
        *,
        tolerance: float | None = None,
        patch_size: float | None = None,
        patch_rule: PatchRule | None = None,
        closure: Closure | None = None,
        residual: float | None = None,
        max_iterations: int | None = None,
        scattering_orders: int | None = None,
        engine: Engine | None = None,
        light_groups: LightGroups | None = None,
        zone_basis: ZoneBasis | None = None,
        discretization_error: bool | None = None,
        **keys: Any,
    ) -> None:
        """Sets settings of the solver; those that are not given stay.

        Parameters
        ----------
        tolerance : float, optional
            Relative accuracy of the exchange areas, above 0 and below 1; 0.01 by default. It is that of one solution: the difference of two solutions of the
            rays engine has the errors of both, so that small differences need ``engine="dense"`` or :class:`StateSolver`.
        patch_size : float, optional
            Target edge of a patch, m; a thirtieth of the diagonal by default.
        patch_rule : {"edge", "area", "voxels"}, optional
            What the patch size limits; "area" with a mesh file, else "edge".
        closure : {"measure", "restore"}, optional
            Treatment of row sums that miss closure; "restore" in thermal mode and for the factors of the dense engine, else "measure".
        residual : float, optional
            Power left undistributed by the iteration, relative to the power of the sources; 1e-10 by default.
        max_iterations : int, optional
            Largest number of iterations; 500 by default.
        scattering_orders : int, optional
            Number of terms of the Neumann series that replace the iteration.
        engine : {"auto", "dense", "rays", "spectral", "layered"}, optional
            Representation of the exchange.
        light_groups : {"auto", "each", "all"}, optional
            Lights that are solved separately.
        zone_basis : {"auto", "linear", "constant"}, optional
            Basis of the radiosity in optically thick voxels.
        discretization_error : bool, optional
            Estimates the error of the finite zones by a second solve; true in thermal mode by default.
        """
        given = _given(
            tolerance=tolerance,
            patch_size=patch_size,
            patch_rule=patch_rule,
            closure=closure,
            residual=residual,
            max_iterations=max_iterations,
            scattering_orders=scattering_orders,
            engine=engine,
            light_groups=light_groups,
            zone_basis=zone_basis,
            discretization_error=discretization_error,
            **_further("solve", keys),
        )
        self.document.setdefault("solve", {}).update(given)

    # Computations.

    def solve(
        self,
        *,
        tolerance: float | None = None,
        engine: Engine | None = None,
        closure: Closure | None = None,
        light_groups: LightGroups | None = None,
        zone_basis: ZoneBasis | None = None,
        discretization_error: bool | None = None,
        scattering_orders: int | None = None,
        factors: Factors = "exact",
        max_memory: float = 12.0,
        checkpoint: Path | None = None,
        resume: bool = False,
        keep_factors: Path | None = None,
        threads: int | None = None,
        progress: Progress = None,
        **keys: Any,
    ) -> Solution:
        """Solves the scene.

        The result has the bits of ``zonal solve``, for any number of threads. Other threads of Python run meanwhile; Ctrl-C ends the solve at once.

        Parameters
        ----------
        tolerance, engine, closure, light_groups, zone_basis, discretization_error, scattering_orders : optional
            In place of the settings of the scene, see :meth:`settings`.
        factors : {"exact", "series", "prop1", "point"}
            Formula of the exchange factor of two voxels; those of the 1996 paper are for comparison.
        max_memory : float
            Memory limit, GB; less memory means fewer rays and larger errors.
        checkpoint : path, optional
            Folder for finished stages during the solve. It is removed after the solve; an interrupted one leaves it.
        resume : bool
            Continues with the stages in the folder, if they belong to this scene.
        keep_factors : path, optional
            Folder for the exchange factors after the solve, which :meth:`Solution.relight` needs for other reflectances.
        threads : int, optional
            Number of threads, 1 to 1024; all cores by default.
        progress : callable or bool, optional
            A function of the stage, the steps done and their number; or true for a bar.

        Returns
        -------
        Solution

        Raises
        ------
        InputError
            If the scene is not valid.
        MemoryLimitError
            If the solve would exceed the memory limit.

        Examples
        --------
        >>> import zonal as zn
        >>> scene = zn.Scene()
        >>> scene.surface(room=([0, 0, 0], [4, 3, 2.5]), name="walls", reflectance=0.5, patch_size=1.0)
        >>> scene.surface(rectangle=([1.8, 1.3, 2.4], [0, 0.4, 0], [0.4, 0, 0]), name="lamp", emission=500.0)
        >>> solution = scene.solve(tolerance=0.05)
        >>> solution.radiosity.shape == (solution.zone_count, 3)
        True
        """
        native = self._native(threads)
        settings = _given(
            tolerance=tolerance,
            engine=engine,
            closure=closure,
            light_groups=light_groups,
            zone_basis=zone_basis,
            discretization_error=discretization_error,
            scattering_orders=scattering_orders,
            **_further("solve", keys),
        )
        run = {
            "memory_limit": memory_limit(max_memory),
            "checkpoint": _checkpoint(checkpoint, keep_factors),
            "resume": resume,
            "keep_factors": _optional_path(keep_factors),
            "factors": factors,
        }
        with observed(progress) as function:
            return Solution(_zonal.solve(native, toml_text(settings), run, function, threads))

    def check(
        self,
        *,
        tolerance: float | None = None,
        engine: Engine | None = None,
        max_memory: float = 12.0,
        threads: int | None = None,
        progress: Progress = None,
        **keys: Any,
    ) -> dict[str, Any]:
        """Validates the scene and forecasts the cost of a solve, as ``zonal check --json``.

        Parameters
        ----------
        tolerance, engine, max_memory, threads, progress : optional
            As of :meth:`solve`.

        Returns
        -------
        dict
            ``verdict`` ("valid" or "refused"), numbers of zones, ``seconds`` and ``memory_bytes`` (expected, upper bound), ``engine``, ``warnings``, …

        Raises
        ------
        InputError
            If the scene is not valid.

        Examples
        --------
        >>> import zonal as zn
        >>> scene = zn.Scene()
        >>> scene.surface(room=([0, 0, 0], [1, 1, 1]), patch_size=0.5)
        >>> scene.check()["patches"]
        24
        """
        native = self._native(threads)
        settings = toml_text(_given(tolerance=tolerance, engine=engine, **_further("solve", keys)))
        with observed(progress) as function:
            report: dict[str, Any] = json.loads(_zonal.check(native, settings, memory_limit(max_memory), function, threads))
        return report

    def exchange(
        self,
        *,
        tolerance: float = 1e-9,
        max_memory: float = 12.0,
        direct_only: bool = False,
        threads: int | None = None,
        progress: Progress = None,
    ) -> ExchangeAreas:
        """Computes the exchange areas of all pairs of zones, as ``zonal exchange``.

        Parameters
        ----------
        tolerance : float
            Relative tolerance of the factors of axis-aligned pairs and of pairs of plates; factors measured by rays have that of the scene.
        max_memory : float
            Memory limit of the matrices, GB.
        direct_only : bool
            Leaves out the total exchange areas, whose time grows with the cube of the number of zones.
        threads, progress : optional
            As of :meth:`solve`.

        Returns
        -------
        ExchangeAreas

        Examples
        --------
        >>> import zonal as zn
        >>> scene = zn.Scene(mode="thermal")
        >>> scene.surface(room=([0, 0, 0], [1, 1, 1]), name="wall", emissivity=1.0, temperature=300, patch_size=1.0)
        >>> areas = scene.exchange()
        >>> areas.direct[0, 0, 1].round(6)  # two opposite walls of the unit cube
        np.float64(0.199825)
        """
        native = self._native(threads)
        settings = {"tolerance": tolerance, "memory_limit": memory_limit(max_memory), "direct_only": direct_only}
        with observed(progress) as function:
            return ExchangeAreas(_zonal.exchange(native, settings, function, threads))

    def dataset(
        self,
        vary: Mapping[str, Distribution] | None = None,
        *,
        inputs: Mapping[str, Any] | Path | None = None,
        n: int | None = None,
        seed: int = 1,
        output: Path | None = None,
        engine: Engine | None = None,
        discretization_error: bool = False,
        max_memory: float = 12.0,
        threads: int | None = None,
        progress: Progress = None,
    ) -> Dataset:
        """Solves the scene many times with sampled numbers, as ``zonal dataset``.

        A key names a number of the scene by its path: ``medium.heat_source``, ``surface.NAME.temperature``, ``surface.0.emissivity``, ``medium.max.2``,
        ``surface.*.emissivity`` (all of them get the same value). Sample i depends on the scene, the varied numbers, the seed and i only.

        Parameters
        ----------
        vary : dict, optional
            By key: ``(low, high)`` for a uniform distribution, a list of numbers of which one is taken, a number, or a text such as ``"log:1:100"``
            (uniform in the logarithm) or ``"normal:5:2"`` (mean and deviation).
        inputs : dict of arrays or path, optional
            In place of ``vary``: the values of the samples by key, or a table (``.csv``) with a column for each key.
        n : int, optional
            Number of samples; 100 by default, or all rows of ``inputs``.
        seed : int
            Seed of the samples.
        output : path, optional
            File to write (``.npz``); an interrupted call continues when it is made again with the same file. Without one nothing is kept on disk.
        engine : optional
            As of :meth:`solve`; by default that of the scene, else spectral for boxes.
        discretization_error : bool
            Estimates the error of the finite zones of every sample by a second solve.
        max_memory : float
            Memory limit of all solves that run at a time, GB.
        threads, progress : optional
            As of :meth:`solve`.

        Returns
        -------
        Dataset

        Raises
        ------
        InputError
            If a key or a distribution is not valid, or the first sample is refused.

        Warns
        -----
        RuntimeWarning
            For samples that are refused, up to five of them.

        Examples
        --------
        >>> import zonal as zn
        >>> scene = zn.Scene(mode="thermal")
        >>> scene.surface(room=([0, 0, 0], [1, 1, 1]), name="wall", emissivity=0.8, temperature=500, patch_size=1.0)
        >>> scene.medium([0, 0, 0], [1, 1, 1], cells=[1, 1, 1], extinction=0.5, heat_source=0)
        >>> made = scene.dataset({"medium.heat_source": (0.0, 9000.0), "surface.wall.emissivity": [0.5, 0.9]}, n=3)
        >>> made.inputs.shape, made["named_power"].shape, made.status
        ((3, 2), (3, 7), ['converged', 'converged', 'converged'])
        """
        import csv
        import tempfile
        import warnings

        if bool(vary) == (inputs is not None):
            raise InputError("vary, inputs: give either the numbers to vary with their distributions, or their values")
        with tempfile.TemporaryDirectory() as folder:
            template = self._path if self._path is not None and _equal(self.document, self._original) else _Path(folder) / "scene.toml"
            if template.parent == _Path(folder):
                self.save(template)
            table = inputs
            if isinstance(inputs, Mapping):
                columns = {key: np.atleast_1d(np.asarray(x, dtype=np.float64)) for key, x in inputs.items()}
                if len({c.shape for c in columns.values()}) != 1 or any(c.ndim != 1 for c in columns.values()):
                    raise InputError("inputs: the columns differ in length; give one number for each sample and key")
                table = _Path(folder) / "inputs.csv"
                with open(table, "w", newline="", encoding="utf-8") as file:
                    rows = csv.writer(file)
                    rows.writerow(columns)
                    rows.writerows([[repr(float(x)) for x in row] for row in zip(*columns.values(), strict=True)])
            target = os.fspath(output) if output is not None else os.fspath(_Path(folder) / "set.npz")
            settings: dict[str, Any] = {"template": os.fspath(template), "output": target, "n": n, "seed": seed, "engine": engine}
            settings |= {"inputs": table, "discretization_error": discretization_error, "memory_limit": memory_limit(max_memory)}
            settings["vary"] = [(key, distribution(key, given)) for key, given in (vary or {}).items()]
            with observed(progress) as function:
                notes = _zonal.write_dataset(settings, function, threads)
            for text in notes:
                warnings.warn(text, RuntimeWarning, stacklevel=2)
            return load_dataset(target)


def _moment(time: str | datetime | None) -> str | None:
    return time.isoformat() if isinstance(time, datetime) else time


def _optional_path(path: Path | None) -> str | None:
    return None if path is None else os.fspath(path)


def _checkpoint(checkpoint: Path | None, keep_factors: Path | None) -> str | None:
    if checkpoint is None and keep_factors is not None:
        return os.fspath(keep_factors) + ".checkpoint"
    return _optional_path(checkpoint)


def _placed_mesh(mesh: Mesh, scale: float | None, translate: Vector | None, rotate_degrees: Vector | None) -> dict[str, Any]:
    return _given(file=mesh, scale=scale, translate=translate, rotate_degrees=rotate_degrees)


def _is_grid(value: Any) -> bool:
    return (isinstance(value, np.ndarray) or is_labelled(value)) and value.ndim == 3


def _shape(value: Any) -> list[int]:
    if is_labelled(value) and sorted(str(d) for d in value.dims) == ["x", "y", "z"]:
        value = value.transpose("x", "y", "z")
    return [int(n) for n in value.shape]


def _density(value: Any, low: Vector, high: Vector) -> dict[str, Any]:
    """A density that fills the box of its coordinates, or else a box."""
    if is_labelled(value) and all(d in value.coords for d in value.dims):
        return value
    return {"file": value, "min": low, "max": high}


def load_scene(path: Path) -> Scene:
    """Opens a scene file.

    An unchanged scene is read by the solver as it stands; errors name line and column. Names of files in it are relative to its folder.

    Parameters
    ----------
    path : path
        Scene file (``.toml``).

    Returns
    -------
    Scene

    Raises
    ------
    InputError
        If the file cannot be read or is not TOML.

    Examples
    --------
    >>> import tempfile, zonal as zn
    >>> path = tempfile.mkdtemp() + "/box.toml"
    >>> scene = zn.Scene()
    >>> scene.surface(box=([0, 0, 0], [1, 1, 1]), emission=1.0)
    >>> scene.save(path)
    >>> zn.load_scene(path).check()["verdict"]
    'valid'
    """
    return Scene._load(path)  # pyright: ignore[reportPrivateUsage]
