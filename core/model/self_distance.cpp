// SPDX-License-Identifier: Apache-2.0
// Calls Coal's distance of convex polytopes.
#include "model/self_distance.hpp"

#include <coal/distance.h>
#include <coal/shape/convex.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace robotskin {
namespace {

using Points = std::vector<coal::Vec3s>;

struct Body {
  int joint;
  std::unique_ptr<coal::ConvexBase> hull;
  coal::Vec3s centre;  // of the sphere around it, in the joint's frame
  double radius;
};

Body body_of(const RobotModel& robot, const BodyHull& hull, std::size_t index) {
  const std::string name = "hull " + std::to_string(index);
  if (hull.joint < RobotModel::base || hull.joint >= static_cast<int>(robot.joint_count()))
    throw ModelError(name + " is on joint " + std::to_string(hull.joint) + ": robot '" + robot.name() +
                     "' has joints 0 to " + std::to_string(robot.joint_count() - 1) + ", and -1 for the base");
  if (hull.points.size() % 3 != 0 || hull.points.size() < 12)
    throw ModelError(name + " has " + std::to_string(hull.points.size()) +
                     " coordinates: a hull needs four points or more");
  auto points = std::make_shared<Points>();
  coal::Vec3s low = coal::Vec3s::Constant(1e9), high = -low;
  for (std::size_t i = 0; i < hull.points.size(); i += 3) {
    const coal::Vec3s point(hull.points[i], hull.points[i + 1], hull.points[i + 2]);
    if (!point.allFinite()) throw ModelError(name + " has a point that is not finite");
    points->push_back(point);
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const coal::Vec3s centre = 0.5 * (low + high);
  double radius = 0;
  for (const coal::Vec3s& point : *points) radius = std::max(radius, (point - centre).norm());
  try {
    std::unique_ptr<coal::ConvexBase> convex(
        coal::ConvexBase::convexHull(points, static_cast<unsigned>(points->size()), false, ""));
    return {hull.joint, std::move(convex), centre, radius};
  } catch (const std::exception& error) {
    throw ModelError(name + " has no volume: " + error.what());
  }
}

}  // namespace

struct SelfDistance::Workspace {
  struct Pair {
    std::size_t a, b;
    coal::ComputeDistance distance;
    coal::DistanceRequest request;
  };
  struct Candidate {
    double gap;
    std::size_t pair;
  };
  std::vector<Body> bodies;
  std::vector<Pair> pairs;
  std::vector<coal::Transform3s> base_from_body;
  std::vector<coal::Vec3s> centre;  // base frame
  std::vector<Candidate> candidates;
  std::vector<NearPair> near;
  coal::DistanceResult result;
  std::size_t measured = 0;
};

SelfDistance::SelfDistance(const RobotModel& robot, const std::vector<BodyHull>& hulls,
                           std::vector<std::pair<std::size_t, std::size_t>> pairs)
    : workspace_(std::make_unique<Workspace>()) {
  for (std::size_t i = 0; i < hulls.size(); ++i) workspace_->bodies.push_back(body_of(robot, hulls[i], i));
  workspace_->pairs.reserve(pairs.size());
  for (const auto& [a, b] : pairs) {
    if (a >= hulls.size() || b >= hulls.size() || a == b)
      throw ModelError("pair of hulls " + std::to_string(a) + " and " + std::to_string(b) + ": there are hulls 0 to " +
                       std::to_string(hulls.size()) + " (exclusive), a pair is of two");
    coal::DistanceRequest request;
    request.gjk_initial_guess = coal::GJKInitialGuess::CachedGuess;
    workspace_->pairs.push_back(
        {a, b, coal::ComputeDistance(workspace_->bodies[a].hull.get(), workspace_->bodies[b].hull.get()), request});
  }
  workspace_->base_from_body.resize(hulls.size());
  workspace_->centre.resize(hulls.size());
  workspace_->candidates.reserve(pairs.size());
  workspace_->near.reserve(largest_measured);
}

SelfDistance::~SelfDistance() = default;
SelfDistance::SelfDistance(SelfDistance&&) noexcept = default;
SelfDistance& SelfDistance::operator=(SelfDistance&&) noexcept = default;

std::size_t SelfDistance::pair_count() const noexcept {
  return workspace_->pairs.size();
}
std::size_t SelfDistance::measured() const noexcept {
  return workspace_->measured;
}

std::span<const NearPair> SelfDistance::update(const RobotDynamics& dynamics, double reach_m) noexcept {
  Workspace& work = *workspace_;
  for (std::size_t i = 0; i < work.bodies.size(); ++i) {
    const Body& body = work.bodies[i];
    if (body.joint != RobotModel::base) {
      const double* m = &dynamics.base_from_joint()[16 * static_cast<std::size_t>(body.joint)];
      coal::Matrix3s turn;
      turn << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
      work.base_from_body[i] = coal::Transform3s(turn, coal::Vec3s(m[3], m[7], m[11]));
    }
    work.centre[i] = work.base_from_body[i].transform(body.centre);
  }
  work.candidates.clear();
  for (std::size_t i = 0; i < work.pairs.size(); ++i) {
    const auto& pair = work.pairs[i];
    const double reach = reach_m + work.bodies[pair.a].radius + work.bodies[pair.b].radius;
    const double square = (work.centre[pair.a] - work.centre[pair.b]).squaredNorm();
    if (square < reach * reach) work.candidates.push_back({std::sqrt(square) - reach, i});
  }
  if (work.candidates.size() > largest_measured) {
    std::ranges::nth_element(work.candidates, work.candidates.begin() + largest_measured, {},
                             &Workspace::Candidate::gap);
    work.candidates.resize(largest_measured);
    std::ranges::sort(work.candidates, {}, &Workspace::Candidate::pair);
  }
  work.measured = work.candidates.size();
  work.near.clear();
  for (const auto& candidate : work.candidates) {
    auto& pair = work.pairs[candidate.pair];
    work.result.clear();
    const double distance =
        pair.distance(work.base_from_body[pair.a], work.base_from_body[pair.b], pair.request, work.result);
    pair.request.updateGuess(work.result);
    if (!(distance < reach_m)) continue;
    const auto& from = work.result.nearest_points[0];
    const auto& to = work.result.nearest_points[1];
    const auto& normal = work.result.normal;
    work.near.push_back({candidate.pair,
                         work.bodies[pair.a].joint,
                         work.bodies[pair.b].joint,
                         distance,
                         {from[0], from[1], from[2]},
                         {to[0], to[1], to[2]},
                         {normal[0], normal[1], normal[2]}});
  }
  return work.near;
}

}  // namespace robotskin
