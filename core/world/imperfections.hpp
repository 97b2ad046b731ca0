// How far a simulated sensor is from an ideal one; every cell draws its own from the run's seed.
//
// Published: accelerometer offsets to 66 mg and 10-bit steps of 1/256 g, force readings of 0 to 2 counts at rest,
// 10 N full scale, 2.6 s time constant of the thermometer, and what the parts of the published cell allow: at most 250
// proximity measurements a second (VCNL4010). Not published, so chosen here: scale errors, noise of force and
// proximity, drift, the accelerometer's bandwidth of 125 Hz (BMA250: a new value every 4 ms), whose noise the 10 mg
// are, and five temperatures a second (LM71 class).
#pragma once

namespace robotskin::world {

// Counts are those of channels.h. Offsets and scales are drawn evenly within +-; noise is normal, one draw a sample.
struct Imperfections {
  double proximity_noise_counts = 1.2;
  double proximity_offset_counts = 8;  // left over after the cell's own offset correction
  double proximity_scale = 0.05;
  double force_noise_counts = 0.5;
  double force_offset_counts = 1;  // drawn between 0 and twice this
  double force_scale = 0.02;
  double acceleration_noise_g = 0.010;
  double acceleration_offset_g = 0.066;
  double acceleration_scale = 0.03;
  double temperature_noise_c = 0.05;
  double temperature_offset_c = 0.5;
  double drift_counts = 2;      // slow wave of proximity, force and fine temperature
  double drift_period_s = 600;  // each cell within a factor of two of it
  // A sensor holds its value between its own measurements; each cell's sensors have phases of their own. 0: it measures
  // whenever it is read, as the force sensors always do, which hang on the controller's own converter.
  double proximity_period_s = 0.004;
  double acceleration_period_s = 0.004;
  double temperature_period_s = 0.2;

  static constexpr Imperfections none() { return {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 600, 0, 0, 0}; }
};

}  // namespace robotskin::world
