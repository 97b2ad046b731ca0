// SPDX-License-Identifier: Apache-2.0
// How far the simulated robot, its sensors and the camera are from what their estimators assume: one table, from which
// the struct, its Python face and docs/imperfections.md are made.
//
// Every cell, joint, link and surface draws its own share from the run's seed. A value of 0 switches a row off, but for
// the range of reflectance, which is 1 to 1 then.
#pragma once

#include <array>

namespace robotskin::world {

// Rows: name, default, value in the ideal world, unit, what it is, source. "chosen" where nothing is published. Counts
// are those of channels.h.
// clang-format off
#define ROBOTSKIN_IMPERFECTIONS(ROW) \
  ROW(proximity_noise_counts, 1.2, 1.2, "counts", "noise of a sample, standard deviation", "chosen") \
  ROW(proximity_offset_counts, 8, 8, "counts", "offset left over after the cell's own correction, within ±", "chosen") \
  ROW(proximity_scale, 0.05, 0.05, "1", "scale error of the emitter, within ±", "chosen") \
  ROW(proximity_period_s, 0.004, 0.004, "s", "between two measurements of a sensor", "VCNL4010: at most 250 a second") \
  ROW(proximity_exponent, 0.1, 0, "1", "the reading falls with a power of the distance that is off by this share, within ±", "chosen: the square holds for a matt wall alone") \
  ROW(reflectance_least, 0.4, 1, "1", "least reflectance of a surface; 1 is the surface that the curve was measured on", "chosen: skin, cloth and matt paint in the near infrared") \
  ROW(reflectance_most, 1.2, 1, "1", "largest reflectance of a surface", "chosen") \
  ROW(proximity_sees_robot, 1, 0, "0 or 1", "the robot's own links and the floor reflect, too", "chosen: a real sensor knows no difference") \
  ROW(force_noise_counts, 0.5, 0.5, "counts", "noise of a sample, standard deviation", "published readings at rest: 0 to 2 counts") \
  ROW(force_offset_counts, 1, 1, "counts", "offset at rest, between 0 and twice this", "published readings at rest: 0 to 2 counts") \
  ROW(force_scale, 0.02, 0.02, "1", "scale error, within ±", "chosen") \
  ROW(force_offset_n, 0, 0, "N", "further offset of a sensor that was never calibrated, within ±", "chosen") \
  ROW(force_cross_sensor, 0, 0, "1", "share of each sensor's force that shows on another of its cell, within ±", "chosen") \
  ROW(force_projection, 1, 0, "0 or 1", "a sensor feels the part of the contact force along its own normal, friction included", "the cell's three sensors measure normal force") \
  ROW(force_hysteresis, 0.03, 0, "1", "between the loading and the unloading branch, share of the load", "chosen: elastomer sensors have 2 to 10 %") \
  ROW(force_creep, 0.03, 0, "1", "what a constant load grows by in 100 s", "chosen: elastomer sensors have 1 to 5 %") \
  ROW(force_crosstalk, 0.03, 0, "1", "share of a cell's force that the soft layer carries to each neighbouring cell", "chosen") \
  ROW(force_preload_n, 0.3, 0, "N", "pre-load of a sensor by the bending of the skin, between 0 and this", "the paper, II-E, names it; the size is chosen") \
  ROW(acceleration_noise_g, 0.010, 0.010, "g", "noise of a sample, standard deviation", "BMA250 at a bandwidth of 125 Hz") \
  ROW(acceleration_offset_g, 0.066, 0.066, "g", "offset of an axis, within ±", "published readings: to 66 mg") \
  ROW(acceleration_scale, 0.03, 0.03, "1", "scale error of an axis, within ±", "chosen") \
  ROW(acceleration_period_s, 0.004, 0.004, "s", "between two measurements of a sensor", "BMA250: a new value every 4 ms") \
  ROW(acceleration_turn_deg, 0.5, 0, "degrees", "turn of the accelerometer in its cell about each axis, standard deviation", "chosen: placement and soldering of a part") \
  ROW(acceleration_cross_axis, 0.01, 0, "1", "share of each axis that shows on another, within ±", "BMA250: 1 %") \
  ROW(acceleration_nonlinearity, 0.005, 0, "1", "deviation from a line, share of the full scale of 2 g, within ±", "BMA250: 0.5 % of full scale") \
  ROW(acceleration_per_kelvin_g, 0.001, 0, "g/K", "change of the offset with the board's temperature from 25 degrees, within ±", "BMA250: 1 mg/K") \
  ROW(temperature_noise_c, 0.05, 0.05, "K", "noise of a sample, standard deviation", "chosen") \
  ROW(temperature_offset_c, 0.5, 0.5, "K", "offset, within ±", "chosen") \
  ROW(temperature_period_s, 0.2, 0.2, "s", "between two measurements of a sensor", "LM71 class: five a second") \
  ROW(drift_counts, 2, 2, "counts", "slow wave of proximity, force and fine temperature, amplitude", "chosen") \
  ROW(drift_period_s, 600, 600, "s", "of that wave; each cell within a factor of two of it", "chosen") \
  ROW(encoder_bits, 17, 0, "bits", "steps of a joint's encoder: one turn over two to this power; 0: no steps", "chosen: absolute encoders of industrial arms") \
  ROW(encoder_delay_s, 0.001, 0, "s", "age of position and velocity when the controller reads them; whole physics steps", "chosen: one bus cycle") \
  ROW(imu_tilt_deg, 0.2, 0, "degrees", "slow error of an inertial unit's orientation, standard deviation about each level axis", "chosen: MEMS units of the better kind") \
  ROW(imu_bias_deg, 0.2, 0, "degrees", "constant error of that orientation, within ±; its heading is then drawn, too", "chosen") \
  ROW(imu_rate_noise_rad_s, 0.003, 0.003, "rad/s", "noise of its turn rates, standard deviation of a sample", "chosen: MEMS units of the better kind") \
  ROW(imu_rate_bias_rad_s, 0.003, 0, "rad/s", "what its turn rates show at rest, about each axis, within ±", "chosen: a MEMS unit that was zeroed at rest") \
  ROW(imu_delay_s, 0.002, 0, "s", "age of what it tells; whole physics steps", "chosen: a filter and a bus cycle") \
  ROW(robot_force_noise_n, 1, 1, "N", "noise of a foot's force sensor, standard deviation of a sample and axis", "chosen") \
  ROW(robot_moment_noise_nm, 0.1, 0.1, "Nm", "the same of its moments", "chosen") \
  ROW(robot_force_bias_n, 2, 0, "N", "what it shows at rest, within ±", "chosen: a sensor that was tared") \
  ROW(robot_moment_bias_nm, 0.2, 0, "Nm", "the same of its moments", "chosen") \
  ROW(robot_force_bandwidth_hz, 100, 100, "Hz", "of its low-pass; 0: none", "chosen") \
  ROW(robot_force_delay_s, 0.001, 0, "s", "age of what it tells, beside its low-pass; whole physics steps", "chosen: one bus cycle") \
  ROW(joint_friction, 0.03, 0, "1", "Coulomb friction of a joint, share of its effort limit", "chosen: geared arms have 2 to 10 %") \
  ROW(link_shift_mm, 0.5, 0, "mm", "how far a joint sits from where the model has it, in a drawn direction", "chosen: an arm that was not calibrated") \
  ROW(link_turn_deg, 0.2, 0, "degrees", "how far a joint is turned from where the model has it, about a drawn axis", "chosen: an arm that was not calibrated") \
  ROW(link_mass, 0.05, 0, "1", "a link's mass and inertia are this share more or less than the model's", "chosen") \
  ROW(camera_distortion, 0.02, 0, "1", "first radial coefficient of the lens that its calibration left over, within ±", "chosen") \
  ROW(camera_shift_mm, 2, 0, "mm", "how far the camera stands from where it is told to, in a drawn direction", "chosen: a tripod measured by hand") \
  ROW(camera_turn_deg, 0.3, 0, "degrees", "how far the camera is turned from what is told, about a drawn axis", "chosen")
// clang-format on

struct Imperfections {
#define ROW(name, value, ideal, unit, meaning, source) double name = value;
  ROBOTSKIN_IMPERFECTIONS(ROW)
#undef ROW

  // Sensors with noise, offset, scale and drift on a robot and in a world that are just as their models say.
  static constexpr Imperfections ideal() {
    Imperfections result;
#define ROW(name, value, ideal, unit, meaning, source) result.name = ideal;
    ROBOTSKIN_IMPERFECTIONS(ROW)
#undef ROW
    return result;
  }

  // Ideal sensors besides: quantised and limited, nothing else.
  static constexpr Imperfections none() {
    Imperfections result{};
#define ROW(name, value, ideal, unit, meaning, source) result.name = 0;
    ROBOTSKIN_IMPERFECTIONS(ROW)
#undef ROW
    result.reflectance_least = result.reflectance_most = 1;
    result.drift_period_s = 600;
    return result;
  }
};

struct ImperfectionRow {
  const char *name, *unit, *meaning, *source;
  double Imperfections::* value;
};

inline constexpr auto imperfection_table = std::to_array<ImperfectionRow>({
#define ROW(name, value, ideal, unit, meaning, source) {#name, unit, meaning, source, &Imperfections::name},
    ROBOTSKIN_IMPERFECTIONS(ROW)
#undef ROW
});

}  // namespace robotskin::world
