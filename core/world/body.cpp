// SPDX-License-Identifier: Apache-2.0
#include "world/body.hpp"

#include <mujoco/mujoco.h>

#include <cmath>
#include <numeric>
#include <utility>

namespace robotskin::world {

Body::Body(mjModel* model, mjData* data, Mounting mounting, const std::vector<HandDescription>& hands,
           std::vector<Carrier> carriers, const std::vector<int>& robot_joints, const std::vector<double>& effort_limit,
           const ServoGains& gains, const Imperfections& imperfections, std::uint64_t seed, SensorMounting sensors,
           std::size_t base_joints)
    : model_(model),
      data_(data),
      mounting_(std::move(mounting)),
      contact_law_(*model, mounting_),
      contacts_(*model, mounting_, imperfections),
      accelerometer_(mounting_),
      proximity_(*model, mounting_, imperfections, seed),
      temperature_(mounting_),
      sensors_(mounting_.cell_count(), imperfections, seed),
      robot_(*model, *data, robot_joints, effort_limit, gains, imperfections, std::move(sensors), base_joints, seed),
      carriers_(std::move(carriers)) {
  for (const HandDescription& hand : hands) hands_.emplace_back(*model, hand);
  place_.resize(mounting_.cell_count());
  std::iota(place_.begin(), place_.end(), std::size_t{0});
}

void Body::swap_cells(std::size_t one, std::size_t other) {
  std::swap(place_.at(one), place_.at(other));
}

double Body::timestep_s() const {
  return model_->opt.timestep;
}

void Body::step(std::int64_t time_ns) {
  for (const Carrier& carrier : carriers_) carrier.place(*model_, *data_, 1e-9 * static_cast<double>(time_ns));
  mj_step1(model_, data_);
  contact_law_.apply(*model_, *data_);
  robot_.drive(*model_, *data_);
  for (std::size_t i = 0; i < hands_.size(); ++i)
    hands_[i].drive(*model_, *data_, mounting_, contacts_.object_force()[i] > 0);
  mj_step2(model_, data_);
  mj_rnePostConstraint(model_, data_);
  contacts_.update(*model_, *data_);
  accelerometer_.update(*model_, *data_);
  proximity_.update(*data_, robot_.position_address());
  const double time_s = 1e-9 * static_cast<double>(time_ns);
  for (const int cell : contacts_.changed()) temperature_.touch(cell, contacts_.toucher()[cell], time_s);
  robot_.measure(*model_, *data_, time_ns + std::llround(1e9 * model_->opt.timestep));
}

Truth Body::truth(std::size_t cell, double time_s, const Seen& seen) const {
  const int toucher = contacts_.toucher()[cell];
  return {contacts_.sensor_force()[cell],
          toucher >= 0 ? 0.0 : seen.distance_m,
          toucher >= 0 ? proximity_.reflectance_of_object(toucher) : seen.reflectance,
          accelerometer_.specific_force(cell),
          temperature_.surface_temperature(cell, time_s),
          temperature_.board_temperature(cell, time_s)};
}

Truth Body::truth(std::size_t cell, std::int64_t time_ns, bool with_distance) const {
  const bool looks = with_distance && contacts_.toucher()[cell] < 0;
  return truth(cell, 1e-9 * static_cast<double>(time_ns),
               looks ? proximity_.look(*model_, *data_, cell) : Seen{0.0, 1.0});
}

bool Body::sample(std::size_t cell, std::int64_t time_ns, rs_sample& sample) {
  const double time_s = 1e-9 * static_cast<double>(time_ns);
  // Rays cost most of a reading, and a proximity sensor that holds its value sends none.
  const std::size_t place = place_[cell];
  const bool looks = sensors_.measures_proximity(cell, time_s) && contacts_.toucher()[place] < 0;
  const Seen seen = looks ? proximity_.measure(*model_, *data_, place) : Seen{0.0, 1.0};
  return sensors_.sample(cell, time_s, truth(place, time_s, seen), sample);
}

std::array<double, 16> Body::world_from_cell(std::size_t cell) const {
  const int body = mounting_.cell_body[cell];
  const Matrix3 world_from_body = load9(data_->xmat + 9 * body);
  const Matrix3 r = multiply(world_from_body, mounting_.body_from_cell_rotation[cell]);
  const Vector3 t = load3(data_->xpos + 3 * body) + apply(world_from_body, mounting_.body_from_cell_translation[cell]);
  return {r[0], r[1], r[2], t[0], r[3], r[4], r[5], t[1], r[6], r[7], r[8], t[2], 0, 0, 0, 1};
}

}  // namespace robotskin::world
