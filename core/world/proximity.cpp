// SPDX-License-Identifier: Apache-2.0
#include "world/proximity.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "skin/proximity_curve.hpp"
#include "world/random.hpp"

namespace robotskin::world {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::uint64_t purpose_reflectance = 5;
// sin and cos of 20 degrees, times those of multiples of 60 degrees.
constexpr double s = 0.34202014332566873, c = 0.93969262078590838, h = 0.86602540378443865;
constexpr Vector3 rays[7] = {{0, 0, 1},  {s, 0, c},           {s / 2, s * h, c}, {-s / 2, s * h, c},
                             {-s, 0, c}, {-s / 2, -s * h, c}, {s / 2, -s * h, c}};
// Rays to objects start this far behind the face, because the face enters what presses it.
constexpr double start_behind_m = 0.006;
// Joints may move by so much, all together, before a cell looks again at the rest of the robot: 5 mm at arm's length.
constexpr double stale_rad = 0.005;

double ray_distance(const mjModel& model, const mjData& data, int geom, const Vector3& from, const Vector3& along) {
  if (model.geom_type[geom] == mjGEOM_MESH) return mj_rayMesh(&model, &data, geom, from.data(), along.data(), nullptr);
  return mju_rayGeom(data.geom_xpos + 3 * geom, data.geom_xmat + 9 * geom, model.geom_size + 3 * geom, from.data(),
                     along.data(), model.geom_type[geom], nullptr);
}

// Whether a ray within the sensor's reach can meet the geom's bounding box; `from` and `along` in the geom's frame.
bool meets_box(const mjModel& model, int geom, const Vector3& from, const Vector3& along) {
  const double* box = model.geom_aabb + 6 * geom;  // centre, half sizes
  double enter = 0, leave = skin::proximity_reach_m + start_behind_m;
  for (int a = 0; a < 3; ++a) {
    const double offset = from[a] - box[a], half = box[3 + a];
    if (std::abs(along[a]) < 1e-12) {
      if (std::abs(offset) > half) return false;
      continue;
    }
    const double inverse = 1 / along[a];
    const double near = (-half - offset) * inverse, far = (half - offset) * inverse;
    enter = std::max(enter, std::min(near, far));
    leave = std::min(leave, std::max(near, far));
  }
  return enter <= leave;
}

}  // namespace

struct Proximity::Face {
  Vector3 centre;
  Matrix3 rotation;  // world from cell

  Vector3 normal() const { return {rotation[2], rotation[5], rotation[8]}; }
};

Proximity::Proximity(const mjModel& model, const Mounting& mounting, const Imperfections& imperfections,
                     std::uint64_t seed)
    : mounting_(mounting),
      other_geom_(model.nbody),
      reflectance_(model.nbody),
      known_(mounting.cell_count(), Known{{infinity, 1}, -1}) {
  const double least = imperfections.reflectance_least, most = imperfections.reflectance_most;
  for (int body = 0; body < model.nbody; ++body)
    reflectance_[body] = least + (most - least) * random_unit(stream_key(seed, purpose_reflectance, body), 0);
  for (std::size_t i = 0; i < mounting.object_count(); ++i)
    if (mounting.object_reflectance[i] > 0) reflectance_[mounting.object_body[i]] = mounting.object_reflectance[i];
  const auto& objects = mounting.object_body;
  const auto& cells = mounting.cell_geom;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    if (std::find(objects.begin(), objects.end(), body) != objects.end()) {
      object_geom_.push_back(geom);
    } else if (imperfections.proximity_sees_robot > 0 && std::find(cells.begin(), cells.end(), geom) == cells.end()) {
      for (int other = 0; other < model.nbody; ++other)
        if (other != body) other_geom_[other].push_back(geom);
    }
  }
}

void Proximity::update(const mjData& data, const std::vector<int>& position_address) {
  position_.resize(position_address.size());
  double farthest = 0;
  for (std::size_t i = 0; i < position_.size(); ++i) {
    const double now = data.qpos[position_address[i]];
    farthest = std::max(farthest, std::abs(now - position_[i]));
    position_[i] = now;
  }
  travel_ += farthest;
}

Seen Proximity::strongest(const mjModel& model, const mjData& data, const Face& face, const std::vector<int>& geoms,
                          double behind_m) const {
  Seen best{infinity, 1};
  double most = 0;
  const Vector3 normal = face.normal();
  for (const int geom : geoms) {
    const bool plane = model.geom_type[geom] == mjGEOM_PLANE;
    const Vector3 offset = load3(data.geom_xpos + 3 * geom) - face.centre;
    if (!plane) {
      const double radius = model.geom_rbound[geom], bound = skin::proximity_reach_m + radius;
      if (dot(offset, offset) > bound * bound || dot(offset, normal) < -radius) continue;
    }
    const Matrix3 world_from_geom = load9(data.geom_xmat + 9 * geom);
    double nearest = infinity;
    for (const Vector3& ray : rays) {
      const Vector3 along = apply(face.rotation, ray), from = face.centre - behind_m * along;
      if (!plane && !meets_box(model, geom, apply_transposed(world_from_geom, from - face.centre - offset),
                               apply_transposed(world_from_geom, along)))
        continue;
      const double hit = ray_distance(model, data, geom, from, along);
      if (hit >= 0) nearest = std::min(nearest, std::max(hit - behind_m, 0.0));
    }
    const double reflectance = reflectance_[model.geom_bodyid[geom]];
    const double sent_back = reflectance * skin::proximity_from_distance(nearest);
    if (sent_back > most) {
      most = sent_back;
      best = {nearest, reflectance};
    }
  }
  return best;
}

namespace {

Seen stronger(const Seen& first, const Seen& second) {
  return first.reflectance * skin::proximity_from_distance(first.distance_m) >=
                 second.reflectance * skin::proximity_from_distance(second.distance_m)
             ? first
             : second;
}

}  // namespace

Seen Proximity::look(const mjModel& model, const mjData& data, std::size_t cell) const {
  const int body = mounting_.cell_body[cell];
  const Matrix3 world_from_body = load9(data.xmat + 9 * body);
  const Face face{load3(data.xpos + 3 * body) + apply(world_from_body, mounting_.body_from_cell_translation[cell]),
                  multiply(world_from_body, mounting_.body_from_cell_rotation[cell])};
  const Seen object = strongest(model, data, face, object_geom_, start_behind_m);
  return other_geom_[body].empty() ? object : stronger(object, strongest(model, data, face, other_geom_[body], 0));
}

Seen Proximity::measure(const mjModel& model, const mjData& data, std::size_t cell) {
  const int body = mounting_.cell_body[cell];
  const Matrix3 world_from_body = load9(data.xmat + 9 * body);
  const Vector3 centre =
      load3(data.xpos + 3 * body) + apply(world_from_body, mounting_.body_from_cell_translation[cell]);
  Known& known = known_[cell];
  const bool stale = !other_geom_[body].empty() && (known.travel < 0 || travel_ - known.travel > stale_rad);
  const bool object_near = std::any_of(object_geom_.begin(), object_geom_.end(), [&](int geom) {
    const Vector3 offset = load3(data.geom_xpos + 3 * geom) - centre;
    if (model.geom_type[geom] == mjGEOM_PLANE) {
      const double* rotation = data.geom_xmat + 9 * geom;  // a plane has no end: only its height counts
      return std::abs(dot(offset, {rotation[2], rotation[5], rotation[8]})) <= skin::proximity_reach_m;
    }
    const double bound = skin::proximity_reach_m + model.geom_rbound[geom];
    return dot(offset, offset) <= bound * bound;
  });
  if (!stale && !object_near) return known.seen;
  const Face face{centre, multiply(world_from_body, mounting_.body_from_cell_rotation[cell])};
  if (stale) known = {strongest(model, data, face, other_geom_[body], 0), travel_};
  return object_near ? stronger(strongest(model, data, face, object_geom_, start_behind_m), known.seen) : known.seen;
}

}  // namespace robotskin::world
