// SPDX-License-Identifier: Apache-2.0
#include "world/contact_law.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>

namespace robotskin::world {
namespace {

constexpr double impedance = 0.5;
constexpr std::size_t soft_max = 4096;
constexpr std::size_t taken_max = 256;
constexpr double least_depth_m = 1e-9;
constexpr double least_left = 0.05;
// Of a contact's own frequency and the period of a step: above 1.03 the steps would no longer settle.
constexpr double most_radians_a_step = 0.6;
constexpr double same = 1e-9;  // relative difference below which a parameter is left as it is

// Springs in series; infinity stands for a rigid one.
double in_series(double one, double other) {
  return 1 / (1 / one + 1 / other);
}

bool assign(mjtNum& parameter, double value) {
  if (std::abs(parameter - value) <= same * std::abs(value)) return false;
  parameter = value;
  return true;
}

}  // namespace

ContactLaw::ContactLaw(const mjModel& model, const Mounting& mounting) : material_(model.ngeom), cell_(model.ngeom) {
  for (std::size_t i = 0; i < mounting.material_geom.size(); ++i)
    material_[mounting.material_geom[i]] = {
        mounting.material_stiffness_n_per_m[i], mounting.material_local[i] != 0,
        mounting.material_relaxes_by.empty() ? 0 : mounting.material_relaxes_by[i],
        mounting.material_relaxes_by.empty() ? 1 : mounting.material_relaxes_in_s[i]};
  for (const int geom : mounting.cell_geom) {
    cell_[geom] = 1;
    material_[geom] = {mounting.skin_stiffness_n_per_m, true};
  }
  soft_.reserve(soft_max);
  taken_.reserve(taken_max);
}

void ContactLaw::apply(const mjModel& model, mjData& data) {
  soft_.clear();
  for (int i = 0; i < data.ncon && soft_.size() < soft_max; ++i) {
    mjContact& contact = data.contact[i];
    const int first = contact.geom[0], second = contact.geom[1];
    if (first < 0 || second < 0) continue;
    if (material_[first].stiffness_n_per_m == Material::rigid && material_[second].stiffness_n_per_m == Material::rigid)
      continue;
    const bool swapped = cell_[second] != 0;
    soft_.push_back({&contact,
                     {swapped ? second : first, swapped ? first : second},
                     cell_[first] != 0 || swapped,
                     std::max(-contact.dist, least_depth_m),
                     1,
                     0});
  }
  for (Soft& one : soft_) {
    double sum_m = 0, squares = 0;
    for (const Soft& other : soft_) {
      if (other.geom[0] != one.geom[0] || other.geom[1] != one.geom[1]) continue;
      sum_m += other.depth_m;
      squares += other.depth_m * other.depth_m;
    }
    one.share = one.depth_m / sum_m;
    one.pair_m = squares / sum_m;
  }
  for (Soft& one : soft_) {
    double sum_m = 0;
    for (const Soft& other : soft_)
      if (model.geom_bodyid[other.geom[0]] == model.geom_bodyid[one.geom[0]] &&
          model.geom_bodyid[other.geom[1]] == model.geom_bodyid[one.geom[1]])
        sum_m += other.share * other.pair_m;
    one.side = one.pair_m / sum_m;
  }
  for (Soft& one : soft_)
    if (one.skin && material_[one.geom[1]].relaxes_by > 0) one.left = left(one, model.opt.timestep);
  forget_what_is_apart();
  bool changed = false;
  for (const Soft& one : soft_) changed = set(model, one) || changed;
  if (!changed) return;
  mj_makeConstraint(&model, &data);
  mj_island(&model, &data);
  mj_projectConstraint(&model, &data);
  mj_referenceConstraint(&model, &data);
}

double ContactLaw::left(const Soft& soft, double period_s) {
  const auto same_pair = [&](const Taken& one) { return one.geom[0] == soft.geom[0] && one.geom[1] == soft.geom[1]; };
  auto found = std::find_if(taken_.begin(), taken_.end(), same_pair);
  if (found == taken_.end()) {
    if (taken_.size() >= taken_max) return 1;
    taken_.push_back({{soft.geom[0], soft.geom[1]}, 0, false});
    found = taken_.end() - 1;
  }
  const Material& material = material_[soft.geom[1]];
  // Once a step, also where several points touch.
  if (!found->touched)
    found->depth_m += (soft.pair_m - found->depth_m) * std::min(1.0, period_s / material.relaxes_in_s);
  found->touched = true;
  // k (x - r y) as a share of k x; what is let go quickly stays shallow and pulls nothing.
  return std::clamp(1 - material.relaxes_by * found->depth_m / soft.pair_m, least_left, 1.0);
}

void ContactLaw::forget_what_is_apart() {
  std::erase_if(taken_, [](const Taken& one) { return !one.touched; });
  for (Taken& one : taken_) one.touched = false;
}

bool ContactLaw::set(const mjModel& model, const Soft& soft) const {
  double stiffness_n_per_m = Material::rigid;
  for (const int geom : soft.geom) {
    const Material& material = material_[geom];
    const bool by_place = material.local && soft.skin;
    const double side = (by_place ? 1 : soft.side) * (geom == soft.geom[1] ? soft.left : 1);
    stiffness_n_per_m = in_series(stiffness_n_per_m, material.stiffness_n_per_m * side);
  }
  double inverse_mass = 0;
  for (const int geom : soft.geom) inverse_mass += model.body_invweight0[2 * model.geom_bodyid[geom]];
  if (!(inverse_mass > 0)) return false;
  const double most = most_radians_a_step / model.opt.timestep;
  const double whole = std::min(stiffness_n_per_m * (1 - impedance) * inverse_mass, most * most);
  const double stiffness = whole * soft.share;
  const double damping = 2 * std::sqrt(whole / impedance) * impedance * soft.share;
  mjContact& contact = *soft.contact;
  bool changed = assign(contact.solref[0], -stiffness);
  changed = assign(contact.solref[1], -damping) || changed;
  const double solimp[5] = {impedance, impedance, 0.001, 0.5, 2};
  for (int i = 0; i < 5; ++i) changed = assign(contact.solimp[i], solimp[i]) || changed;
  if (!soft.skin) return changed;
  // The skin has no friction of its own: what touches it says how it slides.
  const int partner = soft.geom[1];
  const mjtNum* own = model.geom_friction + 3 * partner;
  const double friction[5] = {own[0], own[0], own[1], own[2], own[2]};
  for (int i = 0; i < 5; ++i) changed = assign(contact.friction[i], friction[i]) || changed;
  const int dimension = std::max(3, model.geom_condim[partner]);
  changed = changed || contact.dim != dimension;
  contact.dim = dimension;
  return changed;
}

}  // namespace robotskin::world
