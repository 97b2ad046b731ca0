/* SPDX-License-Identifier: Apache-2.0
 * Further channels of a board that has a hygrometer and a gyroscope: included before all else. */
#define RS_FURTHER_CHANNELS(X)                 \
  X(humidity, 0, 12, 100, 4096, "percent")     \
  X(angular_velocity_x, 1, 16, 1, 16, "deg/s") \
  X(angular_velocity_y, 1, 16, 1, 16, "deg/s") \
  X(angular_velocity_z, 1, 16, 1, 16, "deg/s")
#define RS_FURTHER_SENSORS(X)                               \
  X(humidity, 0, humidity, 1, humidity, unknown, "percent") \
  X(angular_velocity, 1, angular_velocity_x, 3, angular_velocity, unknown, "deg/s, cell frame")
/* Warm skin is damp here. */
#define RS_FURTHER_TRUTH(X) X(humidity, 40 + 2 * (truth.surface_temperature_c - 30), 0.25)
