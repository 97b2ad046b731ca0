"""The simulated two ends: links and the robot's body."""

from collections.abc import Callable, Sequence
import enum
from typing import Annotated

import numpy
from numpy.typing import NDArray

import robotskin.errors
import robotskin.model

class Imperfections:
    """
    How far robot, sensors and camera are from what estimators assume; 0 switches one off.
    """

    def __init__(self) -> None: ...
    @staticmethod
    def ideal() -> Imperfections:
        """Noise, offset, scale and drift of sensors; all else as modelled."""

    @staticmethod
    def none() -> Imperfections:
        """Ideal sensors: quantised and limited, nothing else."""

    @staticmethod
    def table() -> list:
        """(name, unit, what it is, source) of each."""

    @property
    def proximity_noise_counts(self) -> float:
        """noise of a sample, standard deviation"""

    @proximity_noise_counts.setter
    def proximity_noise_counts(self, arg: float, /) -> None: ...
    @property
    def proximity_offset_counts(self) -> float:
        """offset left over after the cell's own correction, within ±"""

    @proximity_offset_counts.setter
    def proximity_offset_counts(self, arg: float, /) -> None: ...
    @property
    def proximity_scale(self) -> float:
        """scale error of the emitter, within ±"""

    @proximity_scale.setter
    def proximity_scale(self, arg: float, /) -> None: ...
    @property
    def proximity_period_s(self) -> float:
        """between two measurements of a sensor"""

    @proximity_period_s.setter
    def proximity_period_s(self, arg: float, /) -> None: ...
    @property
    def proximity_exponent(self) -> float:
        """
        the reading falls with a power of the distance that is off by this share, within ±
        """

    @proximity_exponent.setter
    def proximity_exponent(self, arg: float, /) -> None: ...
    @property
    def reflectance_least(self) -> float:
        """
        least reflectance of a surface; 1 is the surface that the curve was measured on
        """

    @reflectance_least.setter
    def reflectance_least(self, arg: float, /) -> None: ...
    @property
    def reflectance_most(self) -> float:
        """largest reflectance of a surface"""

    @reflectance_most.setter
    def reflectance_most(self, arg: float, /) -> None: ...
    @property
    def proximity_sees_robot(self) -> float:
        """the robot's own links and the floor reflect, too"""

    @proximity_sees_robot.setter
    def proximity_sees_robot(self, arg: float, /) -> None: ...
    @property
    def force_noise_counts(self) -> float:
        """noise of a sample, standard deviation"""

    @force_noise_counts.setter
    def force_noise_counts(self, arg: float, /) -> None: ...
    @property
    def force_offset_counts(self) -> float:
        """offset at rest, between 0 and twice this"""

    @force_offset_counts.setter
    def force_offset_counts(self, arg: float, /) -> None: ...
    @property
    def force_scale(self) -> float:
        """scale error, within ±"""

    @force_scale.setter
    def force_scale(self, arg: float, /) -> None: ...
    @property
    def force_offset_n(self) -> float:
        """further offset of a sensor that was never calibrated, within ±"""

    @force_offset_n.setter
    def force_offset_n(self, arg: float, /) -> None: ...
    @property
    def force_cross_sensor(self) -> float:
        """
        share of each sensor's force that shows on another of its cell, within ±
        """

    @force_cross_sensor.setter
    def force_cross_sensor(self, arg: float, /) -> None: ...
    @property
    def force_projection(self) -> float:
        """
        a sensor feels the part of the contact force along its own normal, friction included
        """

    @force_projection.setter
    def force_projection(self, arg: float, /) -> None: ...
    @property
    def force_hysteresis(self) -> float:
        """between the loading and the unloading branch, share of the load"""

    @force_hysteresis.setter
    def force_hysteresis(self, arg: float, /) -> None: ...
    @property
    def force_creep(self) -> float:
        """what a constant load grows by in 100 s"""

    @force_creep.setter
    def force_creep(self, arg: float, /) -> None: ...
    @property
    def force_crosstalk(self) -> float:
        """
        share of a cell's force that the soft layer carries to each neighbouring cell
        """

    @force_crosstalk.setter
    def force_crosstalk(self, arg: float, /) -> None: ...
    @property
    def force_preload_n(self) -> float:
        """pre-load of a sensor by the bending of the skin, between 0 and this"""

    @force_preload_n.setter
    def force_preload_n(self, arg: float, /) -> None: ...
    @property
    def acceleration_noise_g(self) -> float:
        """noise of a sample, standard deviation"""

    @acceleration_noise_g.setter
    def acceleration_noise_g(self, arg: float, /) -> None: ...
    @property
    def acceleration_offset_g(self) -> float:
        """offset of an axis, within ±"""

    @acceleration_offset_g.setter
    def acceleration_offset_g(self, arg: float, /) -> None: ...
    @property
    def acceleration_scale(self) -> float:
        """scale error of an axis, within ±"""

    @acceleration_scale.setter
    def acceleration_scale(self, arg: float, /) -> None: ...
    @property
    def acceleration_period_s(self) -> float:
        """between two measurements of a sensor"""

    @acceleration_period_s.setter
    def acceleration_period_s(self, arg: float, /) -> None: ...
    @property
    def acceleration_turn_deg(self) -> float:
        """
        turn of the accelerometer in its cell about each axis, standard deviation
        """

    @acceleration_turn_deg.setter
    def acceleration_turn_deg(self, arg: float, /) -> None: ...
    @property
    def acceleration_cross_axis(self) -> float:
        """share of each axis that shows on another, within ±"""

    @acceleration_cross_axis.setter
    def acceleration_cross_axis(self, arg: float, /) -> None: ...
    @property
    def acceleration_nonlinearity(self) -> float:
        """deviation from a line, share of the full scale of 2 g, within ±"""

    @acceleration_nonlinearity.setter
    def acceleration_nonlinearity(self, arg: float, /) -> None: ...
    @property
    def acceleration_per_kelvin_g(self) -> float:
        """
        change of the offset with the board's temperature from 25 degrees, within ±
        """

    @acceleration_per_kelvin_g.setter
    def acceleration_per_kelvin_g(self, arg: float, /) -> None: ...
    @property
    def temperature_noise_c(self) -> float:
        """noise of a sample, standard deviation"""

    @temperature_noise_c.setter
    def temperature_noise_c(self, arg: float, /) -> None: ...
    @property
    def temperature_offset_c(self) -> float:
        """offset, within ±"""

    @temperature_offset_c.setter
    def temperature_offset_c(self, arg: float, /) -> None: ...
    @property
    def temperature_period_s(self) -> float:
        """between two measurements of a sensor"""

    @temperature_period_s.setter
    def temperature_period_s(self, arg: float, /) -> None: ...
    @property
    def drift_counts(self) -> float:
        """slow wave of proximity, force and fine temperature, amplitude"""

    @drift_counts.setter
    def drift_counts(self, arg: float, /) -> None: ...
    @property
    def drift_period_s(self) -> float:
        """of that wave; each cell within a factor of two of it"""

    @drift_period_s.setter
    def drift_period_s(self, arg: float, /) -> None: ...
    @property
    def encoder_bits(self) -> float:
        """
        steps of a joint's encoder: one turn over two to this power; 0: no steps
        """

    @encoder_bits.setter
    def encoder_bits(self, arg: float, /) -> None: ...
    @property
    def encoder_delay_s(self) -> float:
        """
        age of position and velocity when the controller reads them; whole physics steps
        """

    @encoder_delay_s.setter
    def encoder_delay_s(self, arg: float, /) -> None: ...
    @property
    def imu_tilt_deg(self) -> float:
        """
        slow error of an inertial unit's orientation, standard deviation about each level axis
        """

    @imu_tilt_deg.setter
    def imu_tilt_deg(self, arg: float, /) -> None: ...
    @property
    def imu_bias_deg(self) -> float:
        """
        constant error of that orientation, within ±; its heading is then drawn, too
        """

    @imu_bias_deg.setter
    def imu_bias_deg(self, arg: float, /) -> None: ...
    @property
    def imu_rate_noise_rad_s(self) -> float:
        """noise of its turn rates, standard deviation of a sample"""

    @imu_rate_noise_rad_s.setter
    def imu_rate_noise_rad_s(self, arg: float, /) -> None: ...
    @property
    def imu_rate_bias_rad_s(self) -> float:
        """what its turn rates show at rest, about each axis, within ±"""

    @imu_rate_bias_rad_s.setter
    def imu_rate_bias_rad_s(self, arg: float, /) -> None: ...
    @property
    def imu_delay_s(self) -> float:
        """age of what it tells; whole physics steps"""

    @imu_delay_s.setter
    def imu_delay_s(self, arg: float, /) -> None: ...
    @property
    def robot_force_noise_n(self) -> float:
        """
        noise of a foot's force sensor, standard deviation of a sample and axis
        """

    @robot_force_noise_n.setter
    def robot_force_noise_n(self, arg: float, /) -> None: ...
    @property
    def robot_moment_noise_nm(self) -> float:
        """the same of its moments"""

    @robot_moment_noise_nm.setter
    def robot_moment_noise_nm(self, arg: float, /) -> None: ...
    @property
    def robot_force_bias_n(self) -> float:
        """what it shows at rest, within ±"""

    @robot_force_bias_n.setter
    def robot_force_bias_n(self, arg: float, /) -> None: ...
    @property
    def robot_moment_bias_nm(self) -> float:
        """the same of its moments"""

    @robot_moment_bias_nm.setter
    def robot_moment_bias_nm(self, arg: float, /) -> None: ...
    @property
    def robot_force_bandwidth_hz(self) -> float:
        """of its low-pass; 0: none"""

    @robot_force_bandwidth_hz.setter
    def robot_force_bandwidth_hz(self, arg: float, /) -> None: ...
    @property
    def robot_force_delay_s(self) -> float:
        """age of what it tells, beside its low-pass; whole physics steps"""

    @robot_force_delay_s.setter
    def robot_force_delay_s(self, arg: float, /) -> None: ...
    @property
    def joint_friction(self) -> float:
        """Coulomb friction of a joint, share of its effort limit"""

    @joint_friction.setter
    def joint_friction(self, arg: float, /) -> None: ...
    @property
    def link_shift_mm(self) -> float:
        """how far a joint sits from where the model has it, in a drawn direction"""

    @link_shift_mm.setter
    def link_shift_mm(self, arg: float, /) -> None: ...
    @property
    def link_turn_deg(self) -> float:
        """
        how far a joint is turned from where the model has it, about a drawn axis
        """

    @link_turn_deg.setter
    def link_turn_deg(self, arg: float, /) -> None: ...
    @property
    def link_mass(self) -> float:
        """a link's mass and inertia are this share more or less than the model's"""

    @link_mass.setter
    def link_mass(self, arg: float, /) -> None: ...
    @property
    def camera_distortion(self) -> float:
        """
        first radial coefficient of the lens that its calibration left over, within ±
        """

    @camera_distortion.setter
    def camera_distortion(self, arg: float, /) -> None: ...
    @property
    def camera_shift_mm(self) -> float:
        """
        how far the camera stands from where it is told to, in a drawn direction
        """

    @camera_shift_mm.setter
    def camera_shift_mm(self, arg: float, /) -> None: ...
    @property
    def camera_turn_deg(self) -> float:
        """how far the camera is turned from what is told, about a drawn axis"""

    @camera_turn_deg.setter
    def camera_turn_deg(self, arg: float, /) -> None: ...

class ServoGains:
    """Inner position loop: C v + g + M (kp e + kd de/dt + ki integral e)."""

    def __init__(self) -> None: ...
    @property
    def stiffness(self) -> float:
        """1/s^2"""

    @stiffness.setter
    def stiffness(self, arg: float, /) -> None: ...
    @property
    def damping(self) -> float:
        """1/s"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...
    @property
    def integral(self) -> float:
        """1/s^3"""

    @integral.setter
    def integral(self, arg: float, /) -> None: ...

class HandDescription:
    """A weightless ball on three sliding joints of the world."""

    def __init__(self, body: int, joint: int, radius_m: float, mass_kg: float, parking: Sequence[float]) -> None: ...
    @property
    def radius_m(self) -> float:
        """m, of the ball"""

    @property
    def mass_kg(self) -> float:
        """kg, that it moves with"""

class Waypoint:
    """Where a carried thing is at a time of its path."""

    def __init__(self, time_s: float, position_m: Sequence[float], orientation: Sequence[float]) -> None: ...

class Carrier:
    """A thing that goes its way whatever it meets."""

    def __init__(self, joint: int, path: Sequence[Waypoint], smooth: bool, repeats: bool, begin_s: float) -> None: ...

class HandTask(enum.Enum):
    """What a hand is doing."""

    parked = 0

    approaching = 1

    pushing = 2

    leaving = 3

class SimulatedRobot(robotskin.model.RobotPort):
    """A robot that exists in MuJoCo only, behind the port of a real one."""

class Body:
    """
    Robot, cells, hands and objects in one MuJoCo model, shared with Python.
    """

    def __init__(
        self,
        model_address: int,
        data_address: int,
        owner: object,
        cell_body: Sequence[int],
        cell_geom: Sequence[int],
        body_from_cell: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 4, 4), order="C", device="cpu", writable=False)
        ],
        cell_neighbours: Sequence[Sequence[int]],
        object_body: Sequence[int],
        object_temperature: Sequence[float],
        object_reflectance: Sequence[float],
        ambient_temperature: float,
        material_geom: Sequence[int],
        material_stiffness: Sequence[float],
        material_local: Sequence[bool],
        material_relaxes_by: Sequence[float],
        material_relaxes_in_s: Sequence[float],
        skin_stiffness: float,
        hands: Sequence[HandDescription],
        carriers: Sequence[Carrier],
        robot_joints: Sequence[int],
        effort_limit: Sequence[float],
        gains: ServoGains,
        imperfections: Imperfections,
        seed: int,
        sensors: robotskin.model.PortSensors = ...,
        imu_body: Sequence[int] = [],
        force_body: Sequence[int] = [],
        base_joints: int = 0,
    ) -> None: ...
    def step(self, time_ns: int) -> None:
        """One physics step from this time on."""

    @property
    def robot(self) -> SimulatedRobot:
        """the port of the simulated robot"""

    @property
    def sensor_force(self) -> NDArray[numpy.float64]:
        """(N, 3) newton, what each force sensor truly feels"""

    @property
    def object_force(self) -> list[float]:
        """(O) newton, MuJoCo's normal contact force of each object on all cells"""

    @property
    def specific_force(self) -> NDArray[numpy.float64]:
        """(N, 3) m/s^2 in each cell's frame"""

    def distance(self) -> NDArray[numpy.float64]:
        """
        (N, 1) metres to what reflects most, inf where nothing within reach does
        """

    def temperature(self, time_ns: int) -> NDArray[numpy.float64]:
        """(N, 2) degrees Celsius of board and surface"""

    def sample(self, cell: int, time_ns: int) -> list[int]:
        """The nine channels in counts, imperfections included."""

    def sample_all(self, time_ns: int) -> NDArray[numpy.int32]:
        """(N, 9) counts of all cells at once."""

    def world_from_cell(self) -> NDArray[numpy.float64]:
        """(N, 16) metres, a row-major placement of each cell."""

    @property
    def samples(self) -> int:
        """taken by all cells so far"""

    @property
    def saturated_samples(self) -> int:
        """of them, with a channel at its end"""

    def carrier_follow(
        self, carrier: int, path: Sequence[Waypoint], smooth: bool, repeats: bool, begin_s: float
    ) -> None:
        """
        Sends a carried thing on another path, a list of Waypoint, from virtual time `begin_s` on.
        """

    def hand_push(self, hand: int, cell: int, force_n: float, x_m: float, y_m: float) -> None:
        """
        Pushes with so many newton along the inward normal, at the point (x, y) of the cell's face.
        """

    def hand_approach(self, hand: int, cell: int, distance_m: float, speed_m_s: float, x_m: float, y_m: float) -> None:
        """
        Comes so near to the point (x, y) of the cell's face, with at most `speed_m_s`.
        """

    def hand_leave(self, hand: int) -> None:
        """Goes back along the normal, and parks."""

    def hand_task(self, hand: int) -> HandTask:
        """HandTask."""

    def hand_cell(self, hand: int) -> int:
        """Index of the cell that it was last sent to."""

    def set_sensor_fault(
        self,
        cell: int,
        kind: SensorFaultKind,
        channels: Sequence[int] = [],
        size: float = 0.0,
        begin_s: float = 0.0,
        turn: Sequence[float] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    ) -> None:
        """
        What is wrong with a cell from `begin_s` on: its kind, the channels 0 to 8 that it is of, its size in newton, g, share of
        full scale or K (see SensorFaultKind), and of a loose cell the row-major turn that maps its frame now to the one it had.
        """

    def swap_cells(self, one: int, other: int) -> None:
        """Each is found in the other's place from now on."""

class SensorFaultKind(enum.Enum):
    """What may go wrong with the sensors of a cell."""

    none = 0
    """nothing"""

    stuck = 1
    """the channels stay where they are"""

    noisy = 2
    """their noise is so many times as large"""

    drifting = 3
    """their zero moves on and on"""

    offset = 4
    """their zero has moved"""

    mis_scaled = 5
    """they show so many times what they should"""

    loose = 6
    """the cell has turned, and its accelerometer with it"""

    overheated = 7
    """the cell grows so much hotter, within half a minute"""

    end_of_range = 8
    """
    they show the end of their range: the upper one, or the lower one for a size below 0
    """

class SensorModels:
    """The nine channels of N cells without a robot: truth in, counts out."""

    def __init__(self, cells: int, imperfections: Imperfections, seed: int) -> None: ...
    def set_fault(
        self,
        cell: int,
        kind: SensorFaultKind,
        channels: Sequence[int] = [],
        size: float = 0.0,
        begin_s: float = 0.0,
        turn: Sequence[float] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    ) -> None:
        """
        What is wrong with a cell from `begin_s` on: its kind, the channels 0 to 8 that it is of, its size in newton, g, share of
        full scale or K (see SensorFaultKind), and of a loose cell the row-major turn that maps its frame now to the one it had.
        """

    def sample(
        self,
        time_s: float,
        force_n: Annotated[NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)],
        distance_m: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        reflectance: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        specific_force: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 3), order="C", device="cpu", writable=False)
        ],
        temperature_c: Annotated[
            NDArray[numpy.float64], dict(shape=(None, 2), order="C", device="cpu", writable=False)
        ],
    ) -> NDArray[numpy.int32]:
        """
        (N, 9) counts of all cells at one time, from what is true there: force (N, 3) newton of each sensor, distance
        (N) metres, reflectance (N), specific force (N, 3) m/s^2 in the cell frame, temperature (N, 2) of board and surface.
        """

class FaultError(robotskin.errors.RobotskinError):
    """A fault that cannot be read, or whose target does not exist."""

class Fault:
    """
    Something that goes wrong in a network at a time; its text can be read again.
    """

    def __init__(self, text: str) -> None:
        """For instance 'cut:cell=12,port=3@120ms'. Raises FaultError."""

    def __str__(self) -> str: ...
    def __repr__(self) -> str: ...
    def __eq__(self, arg: object, /) -> bool: ...
    @property
    def kind(self) -> str:
        """one of fault_kinds()"""

    @property
    def time_ns(self) -> int:
        """virtual time at which it strikes"""

    @property
    def cell(self) -> int:
        """-1: none"""

    @property
    def unit(self) -> int:
        """-1: none"""

    @property
    def port(self) -> int:
        """0: all"""

    @property
    def lasts_ns(self) -> int:
        """0: for good"""

def fault_kinds() -> list[str]:
    """Names of all kinds, as the text of a fault begins."""

def fault_help() -> str:
    """A line a kind: its keys, their values if left out, what happens."""

def parse_faults(text: str, wiring: Wiring, seed: int) -> list[Fault]:
    """
    The faults of a specification in order of time; 'random:N@TIME' is drawn from the seed. Raises FaultError, also for targets that the wiring does not have.
    """

def draw_faults(wiring: Wiring, count: int, from_ns: int, seed: int) -> list[Fault]:
    """Faults of any kind, half of them within 10 ms of the one before."""

def faults_text(faults: Sequence[Fault]) -> str:
    """One line that parse_faults reads as the same faults."""

class LineQuality:
    """How good wires and clocks are; the faults of a run come from its seed."""

    def __init__(self) -> None: ...
    @property
    def jitter_us(self) -> float:
        """a frame takes up to this much longer than its 50 us"""

    @jitter_us.setter
    def jitter_us(self, arg: float, /) -> None: ...
    @property
    def lost_share(self) -> float:
        """of frames, on each wire"""

    @lost_share.setter
    def lost_share(self, arg: float, /) -> None: ...
    @property
    def bit_error_rate(self) -> float:
        """before the checksum is seen"""

    @bit_error_rate.setter
    def bit_error_rate(self, arg: float, /) -> None: ...
    @property
    def clock_drift_ppm(self) -> float:
        """each cell's clock, within +-"""

    @clock_drift_ppm.setter
    def clock_drift_ppm(self, arg: float, /) -> None: ...
    @property
    def power_up_spread_us(self) -> float:
        """cells start within this time"""

    @power_up_spread_us.setter
    def power_up_spread_us(self, arg: float, /) -> None: ...
    @property
    def unit_skew_us(self) -> float:
        """section units' clocks at the start, within +-"""

    @unit_skew_us.setter
    def unit_skew_us(self, arg: float, /) -> None: ...
    @property
    def unit_drift_ppm(self) -> float:
        """section units' clocks, within +-"""

    @unit_drift_ppm.setter
    def unit_drift_ppm(self, arg: float, /) -> None: ...

class Wiring:
    """Which port is plugged into which."""

    def __init__(
        self,
        neighbours: Annotated[NDArray[numpy.int32], dict(shape=(None, 4, 2), order="C", device="cpu", writable=False)],
        id: Sequence[int],
        units: Sequence[UnitDescription],
    ) -> None:
        """
        neighbours: (N, 4, 2) int32, for own port p at row p - 1 the neighbour's index or -1, and its port; id: (N) kept in the cells' flash, 0: named by the network.
        """

    def __len__(self) -> int: ...

class UnitDescription:
    """A section unit and the cells at its ports."""

    def __init__(
        self, group: int, unit: int, ports: Sequence[tuple[int, int]], skew_ns: int = 0, drift_ppm: float = 0.0
    ) -> None:
        """
        ports: (cell, cell port) of port p at index p - 1; skew and drift of its clock against virtual time.
        """

    @property
    def skew_ns(self) -> int:
        """its clock less virtual time at the start"""

    @skew_ns.setter
    def skew_ns(self, arg: int, /) -> None: ...
    @property
    def drift_ppm(self) -> float:
        """of its clock"""

    @drift_ppm.setter
    def drift_ppm(self, arg: float, /) -> None: ...
    @property
    def group(self) -> int:
        """of the section unit"""

    @property
    def unit(self) -> int:
        """its number in the group"""

class Processor(enum.Enum):
    """
    Of the cells, at 48 MHz: what an input takes is as metered on the chip.
    """

    none = 0
    """computes in no time"""

    zero_wait_states = 1

    one_wait_state = 2
    """for each word that is read from flash"""

def processing_ns(processor: Processor, kind: str, frames: int) -> int:
    """
    What an input of this kind (INPUT_KINDS) takes that starts so many frames.
    """

class NetworkOptions:
    """How a network is run."""

    def __init__(self) -> None: ...
    @property
    def processor(self) -> Processor:
        """of the cells"""

    @processor.setter
    def processor(self, arg: Processor, /) -> None: ...
    @property
    def line(self) -> LineQuality:
        """LineQuality"""

    @line.setter
    def line(self, arg: LineQuality, /) -> None: ...
    @property
    def batch_us(self) -> int:
        """a frame waits at most this long for its datagram; 0: no other"""

    @batch_us.setter
    def batch_us(self, arg: int, /) -> None: ...
    @property
    def unasked(self) -> bool:
        """section units send without a keep-alive"""

    @unasked.setter
    def unasked(self, arg: bool, /) -> None: ...
    @property
    def powered(self) -> bool:
        """ports have power from the start"""

    @powered.setter
    def powered(self, arg: bool, /) -> None: ...
    @property
    def threads(self) -> int:
        """
        that run groups of section units that share no wire side by side, the caller's among them; 0: all is one
        """

    @threads.setter
    def threads(self, arg: int, /) -> None: ...
    @property
    def epoch_ns(self) -> int:
        """the section units' clock at virtual time 0"""

    @epoch_ns.setter
    def epoch_ns(self, arg: int, /) -> None: ...
    @property
    def seed(self) -> int:
        """of all that is drawn by chance"""

    @seed.setter
    def seed(self, arg: int, /) -> None: ...
    @property
    def clock_rate_hz(self) -> int:
        """kept in the cells' flash: 0, 63, 125 or 250"""

    @clock_rate_hz.setter
    def clock_rate_hz(self, arg: int, /) -> None: ...
    @property
    def faults(self) -> list[Fault]:
        """that strike during the run"""

    @faults.setter
    def faults(self, arg: Sequence[Fault], /) -> None: ...
    def set_key(self, key: bytes) -> None:
        """
        32 bytes that host and section units share: datagrams are authenticated in both directions.
        """

    def set_cell_key(self, key: bytes) -> None:
        """
        16 bytes that section units and cells share: ticks and commands are authenticated.
        """

INPUT_KINDS: list = ...

class ExternalCell:
    """
    A cell run elsewhere in place of one of the network's own, and compared with it.
    """

    def __init__(self, step: Callable) -> None:
        """
        `step(kind, port, sent, fault, content, now_us)`, an input of cell.h; content: boot (uid, random, flash, key, step_us), a frame and its late_us, or the sample as 32-bit integers. Answers (frames of 4 ports, timer_us, sample_us or None, waiting, led_rgb or None, flash or None, restart).
        """

    @property
    def input_kind(self) -> str:
        """of the input that it has now, as processing time tells them apart"""

    @property
    def steps(self) -> int:
        """inputs that it has answered"""

    @property
    def samples(self) -> int:
        """of those, that were samples"""

    @property
    def frames(self) -> int:
        """that the external cell sent"""

    @property
    def differences(self) -> int:
        """steps in which it answered otherwise than the host-built cell"""

    @property
    def first_difference(self) -> str:
        """what and when; empty: none"""

class NetworkCounts:
    """What has happened in a network since its start."""

    @property
    def frames_sent(self) -> int:
        """begun on a wire with something at its end"""

    @property
    def frames_delivered(self) -> int:
        """hops"""

    @property
    def frames_lost(self) -> int:
        """on a wire: by chance, cut, or to a dead cell"""

    @property
    def frames_damaged(self) -> int:
        """by bit errors"""

    @property
    def frames_overrun(self) -> int:
        """of those: to a cell too busy to take them"""

    @property
    def cell_steps(self) -> int:
        """inputs that cells have taken"""

    @property
    def events(self) -> int:
        """of virtual time, all kinds"""

    @property
    def datagrams(self) -> int:
        """sent by section units"""

    @property
    def datagram_bytes(self) -> int:
        """in those"""

    @property
    def records(self) -> int:
        """frames inside datagrams"""

class Network:
    """Cells, wires and section units in virtual time."""

    def survey(self) -> dict:
        """
        A row for every cell, as it is now: `alive` (1: has power and runs), `parent_port` (0: none), `hops` (255: no path), `parent_changes` since its boot, and `damaged` (N, 4), frames with a wrong checksum at each port.
        """

    @property
    def cell_count(self) -> int:
        """N"""

    @property
    def unit_count(self) -> int:
        """section units"""

    @property
    def counts(self) -> NetworkCounts:
        """NetworkCounts so far"""

    @property
    def frames_dropped(self) -> int:
        """by full queues of cells and section units"""

    @property
    def queue_peaks(self) -> list[int]:
        """(N) frames waiting in a cell at once, at most"""

    @property
    def depths(self) -> list[int]:
        """(N) hops to the nearest powered port over wires that work, -1: none"""

    @property
    def formed(self) -> bool:
        """every cell that can be reached has an id and its shortest path"""

    @property
    def log_hash(self) -> int:
        """of every frame and datagram so far"""

    @property
    def lane_count(self) -> int:
        """parts that share nothing, if they are run apart"""

    def alive(self, cell: int) -> bool:
        """Whether it has power and runs."""

    def cell_id(self, cell: int) -> int:
        """0: not named yet."""

    def cell_hops(self, cell: int) -> int:
        """To its section unit, as it believes; 255: without a way."""

    def cell_parent_port(self, cell: int) -> int:
        """1 to 4, 0: no parent."""

    def contribute(self, cell: int, limb: int, torque: Sequence[int], active: bool = False, age: int = 0) -> None:
        """
        What a cell adds to its limb's joints in each epoch, in the limb's step; up to 12 joints, none: nothing.
        """

    def set_torque_image(self, cell: int, image: bytes) -> None:
        """Torque parameters in a cell's flash, which it finds at its next start."""

    def put(self, cell: int, external: ExternalCell) -> None:
        """From its boot on the external cell lives as this cell."""

    def torque_epochs(self, unit: int) -> tuple:
        """
        epochs handed over with all that was expected, and without; frames that came after that
        """

    def rate_divisors(self, unit: int) -> list[int]:
        """of each port"""

    def cell_led(self, cell: int) -> int:
        """0xRRGGBB of its light."""

    def cut(self, cell: int, port: int, out: bool = True, in_: bool = True) -> None:
        """The wire at this port carries nothing any more."""

    def mend(self, cell: int, port: int) -> None:
        """The wire at this port works again."""

    def kill(self, cell: int) -> None:
        """Takes a cell's power."""

    def reboot(self, cell: int, off_ns: int = 0) -> None:
        """Starts a cell, after this time without power."""

    def inject(self, fault: Fault) -> None:
        """
        Lets a fault strike at its time, which must not be over. Raises FaultError.
        """

class FaultOutcome:
    """
    What a fault did, until the next one struck. Cells that did not run, or were out of reach, at some time since it struck count for `rejoin_ms` and `healed` only.
    """

    @property
    def fault(self) -> Fault:
        """the Fault"""

    @property
    def recovery_ms(self) -> float:
        """until every cell in reach had a way again, for good"""

    @property
    def outage_ms(self) -> float:
        """longest time during which a cell had none"""

    @property
    def rejoin_ms(self) -> float:
        """until every cell in reach had one, restarted ones too"""

    @property
    def cells_cut_off(self) -> int:
        """cells without a way at once, at most"""

    @property
    def healed(self) -> bool:
        """every cell in reach had a way at the end"""

class TrialReport:
    """How a network formed, healed and served the host in one run."""

    @property
    def seconds(self) -> float:
        """of virtual time"""

    @property
    def formation_ms(self) -> float:
        """until every cell first had its shortest way; -1: never"""

    @property
    def named_ms(self) -> float:
        """and an id"""

    @property
    def outcomes(self) -> list[FaultOutcome]:
        """by fault, in the order they struck"""

    @property
    def recovery_max_ms(self) -> float:
        """longest `recovery_ms` of all faults"""

    @property
    def whole(self) -> bool:
        """every cell in reach has a way at the end"""

    @property
    def depth_max(self) -> int:
        """hops at the end, the cable counted"""

    @property
    def extra_depth_mean(self) -> float:
        """hops over the fewest possible"""

    @property
    def extra_depth_max(self) -> int:
        """of the deepest such cell"""

    @property
    def port_loads(self) -> list[list[int]]:
        """cells that report through each port, by unit"""

    @property
    def cells_in_reach(self) -> int:
        """at the end"""

    @property
    def samples_sent(self) -> int:
        """since every cell had an id"""

    @property
    def samples_heard(self) -> int:
        """of these by the host, each counted once"""

    @property
    def samples_lost(self) -> int:
        """sent and never heard"""

    @property
    def samples_twice(self) -> int:
        """duplicates that left the section units"""

    @property
    def host_gap_ms(self) -> float:
        """
        longest silence at the host of a cell that ran and was in reach all the time
        """

    @property
    def cell_gap_ms(self) -> list[float]:
        """(N) longest silence of every cell; -1: never heard"""

    @property
    def steady(self) -> list[int]:
        """(N) 1 if it ran and was in reach all the time"""

    @property
    def latency_mean_ms(self) -> float:
        """from sampling to the section unit's port"""

    @property
    def latency_p99_ms(self) -> float:
        """that 99 % of the samples keep"""

    @property
    def latency_max_ms(self) -> float:
        """of the slowest sample"""

    @property
    def latency_counts(self) -> list[int]:
        """samples by that latency, 10 us each; beyond the last one in it"""

    @property
    def frames_lost(self) -> int:
        """on wires"""

    @property
    def frames_dropped(self) -> int:
        """by full queues"""

    @property
    def queue_peak(self) -> int:
        """frames waiting in a cell at once, at most"""

    @property
    def counts(self) -> NetworkCounts:
        """NetworkCounts"""

    @property
    def log_hash(self) -> int:
        """of every frame and datagram"""

class NetworkTrial:
    """
    A network without a body, run with its faults and measured; the cells lie still.
    """

    def __init__(self, wiring: Wiring, options: NetworkOptions) -> None:
        """Raises FaultError."""

    def run_until(self, time_s: float) -> None:
        """Up to this virtual time."""

    def measure_anew(self) -> None:
        """Samples, gaps and latencies count from now on."""

    def report(self) -> TrialReport:
        """All that was measured so far."""

    @property
    def time_s(self) -> float:
        """s, virtual"""

    @property
    def network(self) -> Network:
        """the Network"""

class Transport:
    """Carries datagrams between section units and host."""

class InProcess(Transport):
    """In process: datagrams wait until they are taken."""

    def __init__(self) -> None: ...
    @property
    def overflowed(self) -> int:
        """
        datagrams dropped, the oldest first, because they were not taken in time
        """

    def post(self, unit: int, datagram: bytes) -> None:
        """From the host to a section unit (its index)."""

    def take(self) -> list:
        """
        What the section units have sent: (unit index, virtual time in ns, datagram) in order.
        """

class UdpTransport(Transport):
    """
    Real UDP, a socket for each section unit; each answers the host that last spoke to it.
    """

    def __init__(
        self, units: int, bind: str = "127.0.0.1", first_port: int = 0, host: tuple[str, int] | None = None
    ) -> None:
        """
        `host`: (host, port) to send to before any host has asked. Raises RuntimeError if a port is taken.
        """

    @property
    def addresses(self) -> list[tuple[str, int]]:
        """(host, port) of each section unit"""

    @property
    def sent(self) -> int:
        """datagrams handed to the system"""

    @property
    def unsent(self) -> int:
        """datagrams without a host, or that the system did not take"""

    @property
    def received(self) -> int:
        """datagrams from the host"""

class World:
    """Body and network in step."""

    def __init__(
        self,
        body: Body | None,
        neighbours: Annotated[NDArray[numpy.int32], dict(shape=(None, 4, 2), order="C", device="cpu", writable=False)],
        id: Sequence[int],
        units: Sequence[UnitDescription],
        options: NetworkOptions,
        transport: Transport,
        step_s: float = 0.001,
    ) -> None: ...
    def run(self, duration_ns: int) -> None:
        """So much virtual time passes."""

    @property
    def time_ns(self) -> int:
        """virtual time"""

    @property
    def body_took_ns(self) -> int:
        """real time of the body's steps so far"""

    @property
    def network_took_ns(self) -> int:
        """real time of the network so far"""

    @property
    def formed_ns(self) -> int:
        """virtual time when the network first was whole, -1: not yet"""

    @property
    def network(self) -> Network:
        """the Network"""
