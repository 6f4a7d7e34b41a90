"""Exchange areas of all pairs of zones, and thermal states of one geometry."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

from . import _zonal
from ._progress import Progress, observed
from ._types import Floats, Integers, Path
from .diagnostics import Diagnostic, of_rows
from .errors import InputError
from .solution import zones_of

__all__ = ["ExchangeAreas", "StateSolver", "ThermalState", "update"]

Rows: TypeAlias = Literal["zone", "face"]
StateValues: TypeAlias = Mapping[str, float] | Floats | float
"""Values by name, an array of one for each zone or face, or one for all."""


class ExchangeAreas:
    """Direct and total exchange areas of all pairs of zones of a scene, m2.

    Direct areas F leave out reflection and scattering; total areas T include them: zone i gives zone j the net power T_ij (sigma T_i^4 - sigma T_j^4). The first axis
    of the matrices is a band, or has one entry where the bands do not differ. All are symmetric to the bit and read-only.

    Made by :meth:`Scene.exchange`.
    """

    def __init__(self, native: _zonal.ExchangeAreas) -> None:
        self._native = native

    def _array(self, name: str) -> Floats:
        try:
            return self._native.array(name)
        except KeyError:
            raise InputError("total: only direct areas were computed; leave out direct_only") from None

    @property
    def direct(self) -> Floats:
        """Direct exchange areas F, (matrices, zones, zones), m2."""
        return self._array("exchange_areas")

    @property
    def direct_error(self) -> Floats:
        """Error radii of :attr:`direct`, m2."""
        return self._array("error_radius")

    @property
    def closure(self) -> Floats:
        """Row sums of F in a closed scene, (matrices, zones), m2: A of a patch, 4 kappa V of a volume."""
        return self._array("closure")

    @property
    def total(self) -> Floats:
        """Total exchange areas T, (matrices, zones, zones), m2."""
        return self._array("total_exchange_areas")

    @property
    def total_error(self) -> Floats:
        """Error radii of :attr:`total`, m2."""
        return self._array("total_error_radius")

    @property
    def total_closure(self) -> Floats:
        """Row sums of T in a closed scene, (matrices, zones), m2."""
        return self._array("total_closure")

    @property
    def zone_count(self) -> int:
        """Number of zones."""
        return self._native.zones

    @property
    def size(self) -> Floats:
        """Area of patches, m2, and volume of volume zones, m3, (zones,)."""
        return self._native.size()

    @property
    def names(self) -> list[str]:
        """Names of the surfaces, of the medium and of the panes."""
        return self._native.names

    @property
    def name_index(self) -> Integers:
        """The index into :attr:`names` of each zone, (zones,)."""
        return self._native.name_index()

    @property
    def grade(self) -> str:
        """The weakest grade of the areas: proved or estimated."""
        return self._native.grade

    @property
    def warnings(self) -> list[Diagnostic]:
        """Warnings: a stated number may be wrong, or an error is unknown or exceeds the tolerance."""
        return of_rows(self._native.diagnostics, "warning")

    @property
    def notes(self) -> list[Diagnostic]:
        """Notes: the stated numbers are valid."""
        return of_rows(self._native.diagnostics, "note")

    def view_factors(self) -> Floats:
        """F_ij / closure_i of the first matrix, (zones, zones): between patches without a medium, view factors."""
        closure = self.closure[0]
        return np.divide(self.direct[0], closure[:, None], out=np.zeros_like(self.direct[0]), where=closure[:, None] > 0)

    def by_name(self, *, total: bool = True) -> tuple[Floats, Floats]:
        """Sums over names and their error radii, (matrices, names, names) each, m2.

        Parameters
        ----------
        total : bool
            Total areas; otherwise direct ones.
        """
        names = ("total_exchange_areas", "total_error_radius") if total else ("exchange_areas", "error_radius")
        for name in names:
            self._array(name)
        return self._native.by_name(names[0]), self._native.by_name(names[1])

    def save(self, path: Path, *, threads: int | None = None, progress: Progress = None) -> list[str]:
        """Writes the areas as ``zonal exchange`` does: ``.npz`` (also for :class:`StateSolver`), ``.csv`` or ``.mtx``.

        Returns
        -------
        list of str
            The written files.
        """
        with observed(progress) as function:
            return [str(p) for p in self._native.write(os.fspath(path), function, threads)]

    def __repr__(self) -> str:
        return f"<zonal.ExchangeAreas: {self.zone_count} zones, {self._native.matrices} matrix(es), {self.grade}>"


@dataclass(frozen=True)
class ThermalState:
    """A thermal state: columns of results by zone, by name and by face.

    Each of :attr:`zones`, :attr:`by_name` and :attr:`by_face` has the columns ``size`` (m2, m3), ``net_power`` (W), ``net_flux`` (W/m2, W/m3), ``temperature`` (K),
    ``incident`` and ``radiosity`` (W/m2), and their errors by the exchange areas (``net_power_exchange_error``, …); unknown errors are infinite. There is no total
    error: that of the finite zones is not estimated, and :meth:`Scene.solve` estimates it.
    """

    names: list[str]
    zones: dict[str, Floats]
    by_name: dict[str, Floats]
    by_face: dict[str, Floats]
    surroundings: float
    """Power incoming from the surroundings, suns and skies minus power escaping to them, W."""
    absorbed_backfaces: float
    """Power absorbed by backs of one-sided surfaces, W."""
    emitters: float
    """Power that lamps send as light, W."""
    balance: float
    """Sum of all net powers, 0 up to errors, W."""

    @property
    def table(self) -> dict[str, Any]:
        """Results by name with the column ``name``, for ``pandas.DataFrame(state.table)``."""
        return {"name": self.names, **self.by_name}


class StateSolver:
    """Thermal states of one geometry for other temperatures, powers and emissivities, from its exchange areas.

    A state of new temperatures or powers costs two products with the stored matrix of each band; one of new emissivities, or of other zones with known powers, also a
    factorization. Zones without a new value keep that of the scene. The light of suns, skies and lamps is that of the scene.

    Parameters
    ----------
    areas : ExchangeAreas or path
        Exchange areas of a scene in thermal mode without nodes and convection, or their ``.npz``.

    Examples
    --------
    >>> import zonal as zn
    >>> scene = zn.Scene(mode="thermal")
    >>> scene.surface(room=([0, 0, 0], [1, 1, 1]), name="wall", emissivity=0.8, temperature=300, patch_size=1.0)
    >>> solver = zn.StateSolver(scene.exchange())
    >>> for kelvin in (400, 500):
    ...     solver.set_temperature({"wall.z0": kelvin})
    ...     print(round(float(solver.solve().by_name["net_power"][4])))
    763
    2373
    """

    def __init__(self, areas: ExchangeAreas | Path, *, threads: int | None = None, progress: Progress = None) -> None:
        if isinstance(areas, ExchangeAreas):
            with observed(progress) as function:
                native = areas._native  # pyright: ignore[reportPrivateUsage]
                self._native = _zonal.StateSolver.of_areas(native, function, threads)
        else:
            self._native = _zonal.StateSolver.read(os.fspath(areas))

    @property
    def names(self) -> list[str]:
        """Names of the surfaces, of the medium and of the panes."""
        return self._native.names

    @property
    def name_index(self) -> Integers:
        """The index into :attr:`names` of each zone, (zones,)."""
        return self._native.name_index()

    @property
    def size(self) -> Floats:
        """Area of patches, m2, and volume of volume zones, m3, (zones,)."""
        return self._native.size()

    def set_temperature(self, values: StateValues, by: Rows = "zone") -> None:
        """Sets known temperatures, K, by name, zone or face.

        Raises
        ------
        InputError
            If a name is unknown, the number of values differs, or a value is out of range.
        """
        zones, x, _ = self._placed(values, by, all_zones=True)
        self._native.set("temperature", zones, x)

    def set_net_power(self, values: StateValues, by: Rows = "zone") -> None:
        """Sets known net powers that leave, W: of a zone, of a face, or of all zones of a name."""
        zones, x, row = self._placed(values, by, all_zones=True)
        size = self.size[zones]
        self._native.set("flux", zones, x / np.bincount(row, size)[row])

    def set_heat_flux(self, values: StateValues, by: Rows = "zone") -> None:
        """Sets known net fluxes that leave, W/m2, of volumes W/m3."""
        zones, x, _ = self._placed(values, by, all_zones=True)
        self._native.set("flux", zones, x)

    def set_emissivity(self, values: StateValues, by: Rows = "zone") -> None:
        """Sets emissivities of patches, 0 to 1, in all bands but that of sunlight."""
        zones, x, _ = self._placed(values, by, all_zones=False)
        self._native.set("emissivity", zones, x)

    def set_surroundings_temperature(self, kelvin: float | None) -> None:
        """Sets the temperature of the surroundings, K; ``None`` for cold ones."""
        self._native.set_surroundings(kelvin)

    def _placed(self, values: StateValues, by: Rows, *, all_zones: bool) -> tuple[Integers, Floats, Integers]:
        """Zones, their values, and the row of each value: a name, a zone, a face, or one row for all."""
        zones, patches, faces = self._native.counts
        count = zones if all_zones else patches
        every = np.arange(count, dtype=np.int64)
        if isinstance(values, Mapping):
            names, index = self.names, self.name_index[:count]
            places = [zones_of(name, names, index) for name in values]
            row = np.repeat(np.arange(len(places)), [len(place) for place in places])
            x = np.array([float(x) for x in values.values()])
            return np.concatenate([every[:0], *places]), x[row], row
        array = np.asarray(values, dtype=np.float64)
        if array.ndim == 0:
            return every, np.full(count, float(array)), np.zeros(count, dtype=np.int64)
        wanted = faces if by == "face" else count
        if array.shape != (wanted,):
            raise InputError(f"values: the array has the shape {array.shape}, and there are {wanted} {by}s; give one value for each")
        if by == "zone":
            return every, np.ascontiguousarray(array), every
        face = self._native.face_index()[:count]
        placed = np.flatnonzero(face >= 0)
        return placed, array[face[placed]], face[placed]

    def solve(self, *, threads: int | None = None, progress: Progress = None) -> ThermalState:
        """Solves the state.

        Returns
        -------
        ThermalState

        Raises
        ------
        InputError
            If the state is not determined.
        """
        with observed(progress) as function:
            found = self._native.solve(function, threads)
        return ThermalState(
            names=self.names,
            zones=found["zones"],
            by_name=found["names"],
            by_face=found["faces"],
            surroundings=found["surroundings"],
            absorbed_backfaces=found["absorbed_backfaces"],
            emitters=found["emitters"],
            balance=found["balance"],
        )


def update(
    areas: ExchangeAreas | Path,
    *,
    temperatures: StateValues | None = None,
    powers: StateValues | None = None,
    heat_flux: StateValues | None = None,
    emissivities: StateValues | None = None,
    surroundings_temperature: float | None = None,
    by: Rows = "zone",
    threads: int | None = None,
    progress: Progress = None,
) -> ThermalState:
    """Fluxes and temperatures for other temperatures, powers or emissivities, as ``zonal update``: one state.

    Every call makes a new :class:`StateSolver`, which reads the areas and prepares the equations again. For several states, as in a loop over time or over
    parameters, make one :class:`StateSolver` and call its methods: in a trial a state took 2.2 ms in place of 113 ms.

    Parameters
    ----------
    areas : ExchangeAreas or path
        Exchange areas of a scene in thermal mode.
    temperatures, powers, heat_flux, emissivities : dict, array or float, optional
        New values, by name or by zone or face: K; W; W/m2 (W/m3 of volumes); 0 to 1.
    surroundings_temperature : float, optional
        Temperature of the surroundings, K.
    by : {"zone", "face"}
        What arrays are by.
    threads, progress : optional
        As of :meth:`Scene.solve`.

    Returns
    -------
    ThermalState
    """
    solver = StateSolver(areas, threads=threads, progress=progress)
    for given, apply in (
        (temperatures, solver.set_temperature),
        (powers, solver.set_net_power),
        (heat_flux, solver.set_heat_flux),
        (emissivities, solver.set_emissivity),
    ):
        if given is not None:
            apply(given, by)
    if surroundings_temperature is not None:
        solver.set_surroundings_temperature(surroundings_temperature)
    return solver.solve(threads=threads, progress=progress)
