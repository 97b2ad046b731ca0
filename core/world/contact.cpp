// SPDX-License-Identifier: Apache-2.0
#include "world/contact.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>

#include "robotskin/geometry.h"

namespace robotskin::world {
namespace {

#define POINT_M(sensor, x_um, y_um) {(x_um) * 1e-6, (y_um) * 1e-6},
constexpr double sensor_point_m[3][2] = {RS_FORCE_SENSOR_POINTS(POINT_M)};
#undef POINT_M

constexpr std::size_t presses_max = 4096;

}  // namespace

std::array<double, 3> sensor_shares(double x_m, double y_m) {
  constexpr double radius_m = 1e-6 * RS_HEXAGON_SIDE_UM;  // of the corners
  std::array<double, 3> share{};
  double sum = 0;
  for (int s = 0; s < 3; ++s) {
    const auto& [sensor_x_m, sensor_y_m] = sensor_point_m[s];
    const double towards = (x_m * sensor_x_m + y_m * sensor_y_m) / std::hypot(sensor_x_m, sensor_y_m);
    share[s] = std::max((1 + towards / radius_m) / 3, 0.0);
    sum += share[s];
  }
  for (double& s : share) s /= sum;
  return share;
}

Contacts::Contacts(const mjModel& model, const Mounting& mounting, const Imperfections& imperfections)
    : mounting_(mounting),
      projection_(imperfections.force_projection > 0),
      crosstalk_(mounting.cell_neighbours.empty() ? 0 : imperfections.force_crosstalk),
      cell_of_geom_(model.ngeom, -1),
      object_of_body_(model.nbody, -1),
      sensor_force_(mounting.cell_count()),
      toucher_depth_m_(mounting.cell_count()),
      toucher_(mounting.cell_count(), -1),
      marked_(mounting.cell_count()),
      object_force_(mounting.object_count()),
      pressed_(mounting.cell_count()) {
  for (std::size_t i = 0; i < mounting.cell_count(); ++i) cell_of_geom_[mounting.cell_geom[i]] = static_cast<int>(i);
  for (std::size_t i = 0; i < mounting.object_count(); ++i)
    object_of_body_[mounting.object_body[i]] = static_cast<int>(i);
  presses_.reserve(presses_max);
  touched_.reserve(mounting.cell_count());
  changed_.reserve(mounting.cell_count());
  beside_.reserve(4 * mounting.cell_count());
}

void Contacts::change(int cell) {
  if (marked_[cell] != 0) return;
  marked_[cell] = 1;
  changed_.push_back(cell);
}

void Contacts::update(const mjModel& model, const mjData& data) {
  for (const int cell : changed_) marked_[cell] = 0;
  changed_.clear();
  for (const int cell : touched_) {
    sensor_force_[cell] = {0, 0, 0};
    toucher_[cell] = -1;
    toucher_depth_m_[cell] = 0;
    change(cell);
  }
  for (const int cell : beside_) {
    sensor_force_[cell] = {0, 0, 0};
    change(cell);
  }
  touched_.clear();
  beside_.clear();
  presses_.clear();
  std::fill(object_force_.begin(), object_force_.end(), 0.0);

  for (int i = 0; i < data.ncon && presses_.size() < presses_max; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.efc_address < 0 || contact.geom[0] < 0 || contact.geom[1] < 0) continue;
    int cell = cell_of_geom_[contact.geom[0]], other = contact.geom[1];
    if (cell < 0) {
      cell = cell_of_geom_[contact.geom[1]];
      other = contact.geom[0];
    }
    if (cell < 0) continue;
    const int object = object_of_body_[model.geom_bodyid[other]];
    if (object < 0) continue;
    mjtNum wrench[6];
    mj_contactForce(&model, &data, i, wrench);
    object_force_[object] += wrench[0];
    double felt = 1;
    if (projection_ && wrench[0] > 0) {
      // The force on the second geom, world frame; rows of `frame` are normal and tangents.
      const Vector3 force = wrench[0] * load3(contact.frame) + wrench[1] * load3(contact.frame + 3) +
                            wrench[2] * load3(contact.frame + 6);
      const Matrix3& body_from_cell = mounting_.body_from_cell_rotation[cell];
      const Vector3 normal = apply(load9(data.xmat + 9 * mounting_.cell_body[cell]),
                                   {body_from_cell[2], body_from_cell[5], body_from_cell[8]});
      const double inwards = cell_of_geom_[contact.geom[1]] == cell ? -dot(force, normal) : dot(force, normal);
      felt = std::max(inwards, 0.0) / wrench[0];
    }
    presses_.push_back({cell, object * static_cast<int>(model.nbody) + mounting_.cell_body[cell],
                        std::max(-contact.dist, 1e-9), wrench[0], felt, load3(contact.pos)});
  }

  for (const Press& press : presses_) {
    double depth_sum_m = 0, force_sum_n = 0;
    for (const Press& other : presses_) {
      if (other.pair != press.pair) continue;
      depth_sum_m += other.depth_m;
      force_sum_n += other.force_n;
    }
    const double force_n = press.felt * force_sum_n * press.depth_m / depth_sum_m;
    const int cell = press.cell, body = mounting_.cell_body[cell];
    const Vector3 in_body = apply_transposed(load9(data.xmat + 9 * body), press.point - load3(data.xpos + 3 * body));
    const Vector3 in_cell =
        apply_transposed(mounting_.body_from_cell_rotation[cell], in_body - mounting_.body_from_cell_translation[cell]);
    const auto share = sensor_shares(in_cell[0], in_cell[1]);
    for (int s = 0; s < 3; ++s) sensor_force_[cell][s] += force_n * share[s];
    if (toucher_[cell] < 0) touched_.push_back(cell);
    if (press.depth_m > toucher_depth_m_[cell]) {
      toucher_depth_m_[cell] = press.depth_m;
      toucher_[cell] = press.pair / static_cast<int>(model.nbody);
    }
    change(cell);
  }
  if (crosstalk_ > 0) spread();
}

// Each neighbour takes its share of what presses a cell, evenly on its sensors; the cell keeps the rest.
void Contacts::spread() {
  for (const int cell : touched_) pressed_[cell] = sensor_force_[cell];
  for (const int cell : touched_) {
    const auto& force = pressed_[cell];
    const double carried_n = crosstalk_ * (force[0] + force[1] + force[2]);
    for (const int neighbour : mounting_.cell_neighbours[cell]) {
      if (neighbour < 0) continue;
      for (int s = 0; s < 3; ++s) {
        sensor_force_[cell][s] -= crosstalk_ * force[s];
        sensor_force_[neighbour][s] += carried_n / 3;
      }
      if (toucher_[neighbour] >= 0) continue;
      beside_.push_back(neighbour);
      change(neighbour);
    }
  }
}

}  // namespace robotskin::world
