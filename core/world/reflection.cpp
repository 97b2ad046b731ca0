#include "world/reflection.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <limits>

#include "skin/proximity_curve.hpp"

namespace robotskin::world {
namespace {

// sin and cos of 20 degrees, times those of multiples of 60 degrees.
constexpr double s = 0.34202014332566873, c = 0.93969262078590838, h = 0.86602540378443865;
constexpr Vector3 rays[7] = {{0, 0, 1},  {s, 0, c},           {s / 2, s * h, c}, {-s / 2, s * h, c},
                             {-s, 0, c}, {-s / 2, -s * h, c}, {s / 2, -s * h, c}};
// Rays start this far behind the face, because the face enters what presses it.
constexpr double start_behind_m = 0.006;

double ray_distance(const mjModel& model, const mjData& data, int geom, const Vector3& from, const Vector3& along) {
  if (model.geom_type[geom] == mjGEOM_MESH) return mj_rayMesh(&model, &data, geom, from.data(), along.data(), nullptr);
  return mju_rayGeom(data.geom_xpos + 3 * geom, data.geom_xmat + 9 * geom, model.geom_size + 3 * geom, from.data(),
                     along.data(), model.geom_type[geom], nullptr);
}

}  // namespace

Reflection::Reflection(const mjModel& model, const Mounting& mounting) : mounting_(mounting) {
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const auto& bodies = mounting.object_body;
    if (std::find(bodies.begin(), bodies.end(), model.geom_bodyid[geom]) != bodies.end()) object_geom_.push_back(geom);
  }
}

double Reflection::distance(const mjModel& model, const mjData& data, std::size_t cell) const {
  const int body = mounting_.cell_body[cell];
  const Matrix3 world_from_body = load9(data.xmat + 9 * body);
  const Vector3 centre =
      load3(data.xpos + 3 * body) + apply(world_from_body, mounting_.body_from_cell_translation[cell]);
  const Matrix3* world_from_cell = nullptr;
  Matrix3 rotation;
  double nearest = std::numeric_limits<double>::infinity();
  for (const int geom : object_geom_) {
    const Vector3 offset = load3(data.geom_xpos + 3 * geom) - centre;
    const double bound = skin::proximity_reach_m + model.geom_rbound[geom];
    if (dot(offset, offset) > bound * bound) continue;
    if (world_from_cell == nullptr) {
      rotation = multiply(world_from_body, mounting_.body_from_cell_rotation[cell]);
      world_from_cell = &rotation;
    }
    for (const Vector3& ray : rays) {
      const Vector3 along = apply(*world_from_cell, ray);
      const double hit = ray_distance(model, data, geom, centre - start_behind_m * along, along);
      if (hit >= 0) nearest = std::min(nearest, std::max(hit - start_behind_m, 0.0));
    }
  }
  return nearest <= skin::proximity_reach_m ? nearest : std::numeric_limits<double>::infinity();
}

}  // namespace robotskin::world
