#include "engine/debris/film.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "engine/base/dispatch.h"
#include "engine/base/units.h"
#include "engine/base/vectors.h"
#include "engine/base/voxels.h"

namespace typodont::debris {
namespace {

constexpr int kMaxNeighbours = 16;  // largest number of neighbours of a cell; a cell of a smooth surface has eight
// largest fraction of a cell's content that may flow out per substep; a larger fraction is unstable
constexpr float kStableShare = 0.4f;
// Volume fraction of solids above which slurry does not flow (random packing of rough grains; Krieger & Dougherty
// 1959).
constexpr double kMaxSolids = 0.6;
constexpr double kDryMass = 1e-16;  // kg; a cell with less water counts as dry

struct Links {                                    // from a cell to its neighbours; the others lead to the cell itself
  std::array<std::int32_t, kMaxNeighbours> to{};  // indices of the neighbouring cells (slots)
  std::array<float, kMaxNeighbours> width{};      // width of each link divided by its length
  std::size_t used = 0;                           // number of links to compute: 0, 8 or 16
};

struct Surface {
  float level = 0;  // m, height of the cell's free surface along `up`
  float rise = 0;   // 1/m², rise of the level divided by the volume that flows in
};

Load scaled(const Load& load, double fraction) {
  Load out;
  add(out, load, fraction);
  return out;
}

/// Computes the flow through eight links of a cell. Adds the outflow to `outflow` and the rate at which level
/// differences decay to `levelling`.
TYPODONT_INLINE void find_flux(const Surface* surface, const Surface& from, float mobility, const std::int32_t* to,
                               const float* widths, float* flux, float& outflow, float& levelling) {
  Eight level{}, rise{}, width;
  for (int k = 0; k < 8; ++k) level[k] = surface[to[k]].level, rise[k] = surface[to[k]].rise;
  std::memcpy(&width, widths, sizeof width);
  const Eight fall = from.level - level, conductance = mobility * width;
  const Eight out = fall > 0 ? conductance * fall : Eight{},
              decay = fall > 0 ? conductance * (from.rise + rise) : Eight{};
  std::memcpy(flux, &out, sizeof out);
  for (int k = 0; k < 8; ++k) outflow += out[k], levelling += decay[k];
}

/// Moves the fractions `fractions` of the mass `mass` of a cell through its links; the fraction `kept` remains.
TYPODONT_INLINE void move(const Links& links, const std::array<double, kMaxNeighbours>& fractions, double& mass,
                          double kept, std::vector<double>& gain) {
  double* const to = gain.data();
  const double all = mass;
  for (std::size_t k = 0; k < links.used; ++k) to[links.to[k]] += fractions[k] * all;
  mass = all * kept;
}

}  // namespace

struct Film::State {
  struct Cell {
    glm::ivec3 sample;
    glm::vec3 p, n;    // p: point on the surface in m; n: unit normal
    float area = 0;    // m², area of the surface that the cell represents
    float height = 0;  // m, height of the point p along `up`
    float tilt = 0;    // cosine between the normal and `up`
    bool drains = false;
  };
  FilmOptions options;
  CoarseField field;
  PerTissue volume_of_kg{};           // m³/kg, volume of one kilogram of each tissue
  std::vector<std::int32_t> slot_at;  // for each sample of the field: index of its cell; -1: no cell
  std::vector<Cell> cells;
  std::vector<Links> links;
  std::vector<Surface> surface;
  std::vector<Load> load;
  std::vector<double> gain;                                   // kg, water that flows into each cell in a substep
  std::array<std::vector<double>, kTissueCount> gain_solids;  // kg, the same for the solids of each tissue
  std::vector<std::array<float, kMaxNeighbours>> flux;  // m³/s, flow through each link of a loaded cell, as in `loaded`
  std::vector<float> content;                           // m³, volume of water and solids in each cell
  // 1/s, for each cell the larger of two rates: outflow / movable content, and decay of level differences to neighbours
  std::vector<float> rate;
  std::vector<std::int32_t> free_slots;
  std::vector<std::int32_t> loaded;  // slots of the cells that contain water or solids
  std::vector<std::uint8_t> is_loaded, is_changed;
  std::vector<std::size_t> present;      // tissues whose solids were deposited at least once
  std::vector<std::uint8_t> has_solids;  // for each cell: 0 if it contains only water, which is computed faster
  std::vector<glm::ivec3> changed;
  bool wet = false;  // true if any cell contains water
  std::uint64_t stepped = 0;
  FilmLedger ledger;

  std::size_t index(const glm::ivec3& s) const { return voxel_index(s, field.size); }
  bool inner(const glm::ivec3& s) const {
    return glm::all(glm::greaterThan(s, glm::ivec3(0))) && glm::all(glm::lessThan(s, field.size - 1));
  }
  std::int32_t slot(const glm::ivec3& s) const { return inner(s) ? slot_at[index(s)] : -1; }

  void mark(std::int32_t i) {
    const auto at = static_cast<std::size_t>(i);
    if (std::exchange(is_changed[at], std::uint8_t{1}) == 0) changed.push_back(cells[at].sample);
  }
  void put(std::int32_t i, const Load& more) {
    const auto at = static_cast<std::size_t>(i);
    if (cells[at].drains) return add(ledger.run_off, more);
    add(load[at], more);
    for (std::size_t t = 0; t < kTissueCount; ++t) {
      if (!(more.solids[t] > 0)) continue;
      has_solids[at] = 1;
      if (std::find(present.begin(), present.end(), t) == present.end()) present.push_back(t);
    }
    if (more.water > 0) wet = true;
    if (std::exchange(is_loaded[at], std::uint8_t{1}) == 0) loaded.push_back(i);
    mark(i);
  }
  double solid_volume(const Load& of) const {
    double volume = 0;
    for (const std::size_t t : present) volume += of.solids[t] * volume_of_kg[t];
    return volume;
  }
  std::int32_t nearest(const glm::dvec3& p) const {
    const glm::dvec3 q = (p - field.origin) / field.spacing;
    if (!glm::all(glm::lessThan(glm::abs(q), glm::dvec3(1e6)))) return -1;
    const glm::ivec3 middle(glm::round(q));
    for (int reach = 1; reach <= 2; ++reach) {
      std::int32_t best = -1;
      double least = 1e9;
      for_each_voxel_between(middle - reach, middle + reach, [&](const glm::ivec3& s) {
        const std::int32_t i = slot(s);
        if (i < 0) return;
        const double far = glm::length(glm::dvec3(cells[static_cast<std::size_t>(i)].p) - p);
        if (far < least) least = far, best = i;
      });
      if (best >= 0) return best;
    }
    return -1;
  }
  std::optional<Cell> made_at(const glm::ivec3& s) const;
  void link(std::int32_t i);
  void rebuild(glm::ivec3 lo, glm::ivec3 hi);
  void remove_by_suction(double dt, const Suction& suction);
  float find_fluxes();
  void flow(double dt);
  void lose(double dt);
  void drop_empty();
};

/// Returns the cell of a sample if the surface passes near it. There is one cell per grid column along the axis nearest
/// to the normal, so that the cells' areas add up to that of the surface.
std::optional<Film::State::Cell> Film::State::made_at(const glm::ivec3& s) const {
  const double d = field.distance[index(s)], h = field.spacing;
  if (std::abs(d) > 0.5 * h) return std::nullopt;
  glm::dvec3 g;
  for (int a = 0; a < 3; ++a) {
    glm::ivec3 before = s, after = s;
    --before[a], ++after[a];
    g[a] = static_cast<double>(field.distance[index(after)]) - field.distance[index(before)];
  }
  const double length = glm::length(g);
  if (!(length > 0.2 * h)) return std::nullopt;
  const glm::dvec3 n = g / length;
  const double most = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
  if (!(d > -0.5 * h * most && d <= 0.5 * h * most)) return std::nullopt;
  Cell cell;
  cell.sample = s;
  const glm::dvec3 p = field.origin + h * glm::dvec3(s) - d * n;
  cell.p = glm::vec3(p);
  cell.n = glm::vec3(n);
  cell.area = static_cast<float>(h * h / most);
  cell.height = static_cast<float>(glm::dot(p, options.up));
  cell.tilt = static_cast<float>(glm::dot(n, options.up));
  cell.drains = glm::dot(options.drain, glm::dvec4(p, 1)) < 0;
  return cell;
}

/// Links the cell to its neighbours. d_k: vector to neighbour k in the tangent plane; c_k: link's width / its length.
void Film::State::link(std::int32_t i) {
  Cell& cell = cells[static_cast<std::size_t>(i)];
  Links& to = links[static_cast<std::size_t>(i)];
  to.to.fill(i), to.width.fill(0);
  std::size_t count = 0;
  const glm::dvec3 n(cell.n);
  const glm::dvec3 e = glm::normalize(glm::cross(n, std::abs(n.x) < 0.8 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0))),
                   f = glm::cross(n, e);
  // for each neighbour: x², xy, y² of its vector d_k = (x, y), in grid spacings
  std::array<glm::dvec3, kMaxNeighbours> products;
  double squares = 0;
  for_each_voxel_between(cell.sample - 1, cell.sample + 1, [&](const glm::ivec3& s) {
    const std::int32_t j = s == cell.sample ? -1 : slot(s);
    if (j < 0 || count == kMaxNeighbours) return;
    const Cell& other = cells[static_cast<std::size_t>(j)];
    if (glm::dot(cell.n, other.n) < -0.5f) return;  // skips a cell on a thin wall's opposite face
    const glm::dvec3 offset = glm::dvec3(other.p - cell.p) / field.spacing;
    const double x = glm::dot(offset, e), y = glm::dot(offset, f);
    products[count] = {x * x, x * y, y * y};
    squares += x * x + y * y;
    to.to[count++] = j;
  });
  to.used = (count + 7) / 8 * 8;
  if (!(squares > 0)) return to.to.fill(i);
  const double area = cell.area / (field.spacing * field.spacing), mean = 4 * area / squares;
  // c_k: conductance of the link to the neighbour at d_k. The flow does not depend on the grid if Σ c_k d_k d_kᵀ =
  // 2 · area · I. So c_k = c (1 + d_kᵀ S d_k), solved for the symmetric matrix S.
  glm::dmat3 system(0.0);
  glm::dvec3 wanted(2 * area / mean, 0, 2 * area / mean);
  for (std::size_t k = 0; k < count; ++k) {
    const glm::dvec3& q = products[k];
    system += glm::outerProduct(q, glm::dvec3(q.x, 2 * q.y, q.z));
    wanted -= q;
  }
  const bool solvable = std::abs(glm::determinant(system)) > 1e-3;
  const glm::dvec3 s = solvable ? glm::inverse(system) * wanted : glm::dvec3(0);
  for (std::size_t k = 0; k < count; ++k) {
    const glm::dvec3& q = products[k];
    // Limits the width: it must not be negative (the film would flow uphill) or very large.
    to.width[k] = static_cast<float>(mean * std::clamp(1 + q.x * s.x + 2 * q.y * s.y + q.z * s.z, 0.05, 4.0));
  }
}

void Film::State::rebuild(glm::ivec3 lo, glm::ivec3 hi) {
  // Cells up to one sample outside the changed box are computed again, and links up to two samples outside.
  const glm::ivec3 first = glm::max(lo - 1, glm::ivec3(1)), last = glm::min(hi + 1, field.size - 2);
  std::vector<std::pair<glm::dvec3, Load>> homeless;  // points and loads of the cells that disappeared
  for_each_voxel_between(first, last, [&](const glm::ivec3& s) {
    std::int32_t& at = slot_at[index(s)];
    const std::optional<Cell> made = made_at(s);
    if (made) {
      if (at < 0) {
        if (free_slots.empty()) {
          at = static_cast<std::int32_t>(cells.size());
          cells.emplace_back(), links.emplace_back(), surface.emplace_back();
          load.emplace_back(), gain.push_back(0), content.push_back(0), rate.push_back(0);
          for (std::vector<double>& gain_of : gain_solids) gain_of.push_back(0);
          is_loaded.push_back(0), is_changed.push_back(0), has_solids.push_back(0);
        } else {
          at = free_slots.back();
          free_slots.pop_back();
        }
      }
      cells[static_cast<std::size_t>(at)] = *made;
      surface[static_cast<std::size_t>(at)] = {made->height, std::max(made->tilt, 0.0f) / made->area};
      mark(at);
    } else if (at >= 0) {
      const auto i = static_cast<std::size_t>(at);
      if (is_loaded[i]) {
        homeless.emplace_back(glm::dvec3(cells[i].p), load[i]);
        load[i] = {};
        std::erase(loaded, at);
        is_loaded[i] = has_solids[i] = 0;
      }
      mark(at);
      is_changed[i] = 0;  // so that a new cell in this slot can be listed as changed, too
      free_slots.push_back(at);
      at = -1;
    }
  });
  const glm::ivec3 low = glm::max(first - 1, glm::ivec3(1)), high = glm::min(last + 1, field.size - 2);
  for_each_voxel_between(low, high, [&](const glm::ivec3& s) {
    if (const std::int32_t at = slot(s); at >= 0) link(at);
  });
  for (const auto& [p, content_of] : homeless) {
    const std::int32_t to = nearest(p);
    if (to < 0)
      add(ledger.run_off, content_of);
    else
      put(to, content_of);
  }
}

void Film::State::remove_by_suction(double dt, const Suction& suction) {
  const double strength = suction.flow / (4 * kPi * options.suction_speed);
  for (const std::int32_t i : loaded) {
    const auto at = static_cast<std::size_t>(i);
    const double r = std::max(glm::length(glm::dvec3(cells[at].p) - suction.p_W), suction.radius);
    const double speeds = strength / (r * r), fraction = -std::expm1(-options.suction_rate * speeds * speeds * dt);
    if (fraction < 1e-6) continue;
    add(ledger.sucked, load[at], fraction);
    load[at] = scaled(load[at], 1 - fraction);
    mark(i);
  }
}

/// Computes the flow from each loaded cell to its neighbours. Returns the largest rate, 1/s.
TYPODONT_DISPATCH("avx2", "default")
float Film::State::find_fluxes() {
  const double per_kg = 1 / options.water_density;
  const auto of_water = static_cast<float>(options.water_density * options.gravity / (3 * options.water_viscosity));
  for (const std::int32_t i : loaded) {
    const auto at = static_cast<std::size_t>(i);
    content[at] = static_cast<float>(load[at].water * per_kg + (has_solids[at] ? solid_volume(load[at]) : 0));
    surface[at].level = cells[at].height + content[at] * surface[at].rise;
  }
  float fastest = 0;
  flux.resize(loaded.size());
  for (std::size_t n = 0; n < loaded.size(); ++n) {
    const auto at = static_cast<std::size_t>(loaded[n]);
    rate[at] = 0;
    const float area = cells[at].area, thick = content[at] / area - static_cast<float>(options.clinging);
    const double fraction = has_solids[at] ? 1 - load[at].water * per_kg / content[at] : 0;
    if (!(thick > 0) || fraction >= kMaxSolids) continue;
    // Viscosity of water / viscosity of the suspension: (1 − φ/φmax)^(2.5 φmax), 2.5 φmax = 1.5 (Krieger & Dougherty
    // 1959)
    const auto room = static_cast<float>(1 - fraction / kMaxSolids);
    const float mobility = of_water * room * std::sqrt(room) * thick * thick * thick;
    float outflow = 0, levelling = 0;
    for (std::size_t k = 0; k < links[at].used; k += 8)
      find_flux(surface.data(), surface[at], mobility, &links[at].to[k], &links[at].width[k], &flux[n][k], outflow,
                levelling);
    rate[at] = std::max(outflow / (thick * area), levelling);
    fastest = std::max(fastest, rate[at]);
  }
  return fastest;
}

void Film::State::flow(double dt) {
  const double least = dt / options.max_substeps;
  for (double left = dt; left > 0;) {
    const float fastest = find_fluxes();
    if (fastest <= 0) return;
    const double part = std::min(left, std::max(least, static_cast<double>(kStableShare / fastest)));
    left = left - part < 1e-3 * least ? 0 : left - part;
    stepped += loaded.size();
    const std::size_t count = loaded.size();
    for (std::size_t n = 0; n < count; ++n) {
      const std::int32_t i = loaded[n];
      const auto at = static_cast<std::size_t>(i);
      if (rate[at] <= 0) continue;
      // Limits the outflow per substep to kStableShare; a faster flow would need a shorter substep.
      const double share = std::min(part, static_cast<double>(kStableShare / rate[at])) / content[at];
      std::array<double, kMaxNeighbours> fractions;  // of the cell's content that flow through each link
      double kept = 1;
      for (std::size_t k = 0; k < links[at].used; ++k) {
        fractions[k] = share * flux[n][k];
        kept -= fractions[k];
        const std::int32_t to = links[at].to[k];
        const auto next = static_cast<std::size_t>(to);
        if (!is_loaded[next] && fractions[k] > 0) {
          is_loaded[next] = 1;
          loaded.push_back(to);
        }
        has_solids[next] = static_cast<std::uint8_t>(has_solids[next] | (has_solids[at] & int{fractions[k] > 0}));
      }
      move(links[at], fractions, load[at].water, kept, gain);
      if (has_solids[at])
        for (const std::size_t t : present) move(links[at], fractions, load[at].solids[t], kept, gain_solids[t]);
      mark(i);
    }
    for (const std::int32_t i : loaded) {
      const auto at = static_cast<std::size_t>(i);
      if (gain[at] <= 0) continue;
      Load& to = cells[at].drains ? ledger.run_off : load[at];
      to.water += std::exchange(gain[at], 0);
      if (has_solids[at])
        for (const std::size_t t : present) to.solids[t] += std::exchange(gain_solids[t][at], 0);
      mark(i);
    }
  }
}

/// Removes the water that evaporates and the drops that fall from overhangs.
void Film::State::lose(double dt) {
  for (const std::int32_t i : loaded) {
    const auto at = static_cast<std::size_t>(i);
    if (load[at].water <= 0) continue;
    const Cell& cell = cells[at];
    if (cell.tilt < options.overhang) {
      const double volume = load[at].water / options.water_density + solid_volume(load[at]);
      const double fraction = 1 - options.hanging * cell.area / volume;
      if (fraction > 0) {
        add(ledger.run_off, load[at], fraction);
        load[at] = scaled(load[at], 1 - fraction);
      }
    }
    const double dried = std::min(load[at].water, options.drying * dt * cell.area * options.water_density);
    ledger.dried += dried;
    load[at].water -= dried;
    if (load[at].water < kDryMass) {
      ledger.dried += load[at].water;
      load[at].water = 0;
    }
    mark(i);
  }
}

void Film::State::drop_empty() {
  wet = false;
  std::erase_if(loaded, [&](std::int32_t i) {
    const auto at = static_cast<std::size_t>(i);
    if (load[at].water > 0) {
      wet = true;
      return false;
    }
    double solids = 0;
    for (const double kg : load[at].solids) solids += kg;
    if (solids >= kDryMass) return false;
    for (std::size_t t = 0; t < kTissueCount; ++t) ledger.run_off.solids[t] += load[at].solids[t];
    load[at] = {};
    surface[at].level = cells[at].height;
    is_loaded[at] = has_solids[at] = 0;
    mark(i);
    return true;
  });
}

Film::Film(const CoarseField& field, const MaterialTable& materials, const FilmOptions& options)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.options = options;
  s.field = field;
  for (std::size_t t = 0; t < kTissueCount; ++t)
    s.volume_of_kg[t] = materials[t].density > 0 ? 1 / materials[t].density : 0;
  s.slot_at.assign(voxel_count(field.size), -1);
  if (field.distance && glm::all(glm::greaterThan(field.size, glm::ivec3(2)))) s.rebuild(glm::ivec3(0), field.size - 1);
  s.changed.clear();
  std::fill(s.is_changed.begin(), s.is_changed.end(), std::uint8_t{0});
}
Film::~Film() = default;
Film::Film(Film&&) noexcept = default;
Film& Film::operator=(Film&&) noexcept = default;

void Film::update(const glm::ivec3& lo, const glm::ivec3& hi) {
  state_->rebuild(lo, hi);
}

void Film::deposit(const glm::dvec3& p_W, const Load& more) {
  State& s = *state_;
  add(s.ledger.deposited, more);
  const std::int32_t to = s.nearest(p_W);
  if (to < 0) return add(s.ledger.run_off, more);
  s.put(to, more);
}

double Film::water_at(const glm::dvec3& p_W) const {
  const State& s = *state_;
  if (!s.wet) return 0;
  const std::int32_t i = s.nearest(p_W);
  if (i < 0) return 0;
  const auto at = static_cast<std::size_t>(i);
  return s.load[at].water / s.options.water_density / s.cells[at].area;
}

Load Film::fling(const glm::dvec3& p_W, double reach, double fraction) {
  State& s = *state_;
  Load out;
  if (s.loaded.empty() || !(fraction > 0)) return out;
  const glm::ivec3 lo(glm::floor((p_W - reach - s.field.origin) / s.field.spacing)),
      hi(glm::ceil((p_W + reach - s.field.origin) / s.field.spacing));
  for_each_voxel_between(lo, hi, [&](const glm::ivec3& sample) {
    const std::int32_t i = s.slot(sample);
    if (i < 0 || !s.is_loaded[static_cast<std::size_t>(i)]) return;
    const auto at = static_cast<std::size_t>(i);
    if (s.load[at].water <= 0 || glm::length(glm::dvec3(s.cells[at].p) - p_W) > reach) return;
    add(out, s.load[at], fraction);
    s.load[at] = scaled(s.load[at], 1 - fraction);
    s.mark(i);
  });
  add(s.ledger.flung, out);
  return out;
}

void Film::step(double dt, const Suction* suction) {
  State& s = *state_;
  if (s.loaded.empty() || (!s.wet && !suction)) return;
  s.stepped += s.loaded.size();
  if (suction) s.remove_by_suction(dt, *suction);
  if (s.wet) {
    s.flow(dt);
    s.lose(dt);
  }
  s.drop_empty();
}

std::size_t Film::loaded() const {
  return state_->loaded.size();
}
std::uint64_t Film::cells_stepped() const {
  return state_->stepped;
}
std::size_t Film::cells() const {
  return state_->cells.size() - state_->free_slots.size();
}
bool Film::has_cell(const glm::ivec3& sample) const {
  return state_->slot(sample) >= 0;
}

FilmCell Film::cell(const glm::ivec3& sample) const {
  const State& s = *state_;
  const std::int32_t i = s.slot(sample);
  if (i < 0) return {};
  const auto at = static_cast<std::size_t>(i);
  const State::Cell& cell = s.cells[at];
  FilmCell out{.sample = sample,
               .p_W = cell.p,
               .n_W = cell.n,
               .area = cell.area,
               .water = s.load[at].water / s.options.water_density / cell.area};
  for (std::size_t t = 0; t < kTissueCount; ++t) out.solids[t] = s.load[at].solids[t] * s.volume_of_kg[t] / cell.area;
  return out;
}

FilmLedger Film::ledger() const {
  FilmLedger out = state_->ledger;
  for (const std::int32_t i : state_->loaded) add(out.on_surface, state_->load[static_cast<std::size_t>(i)]);
  return out;
}

void Film::take_changed(std::vector<glm::ivec3>& out) {
  State& s = *state_;
  out.insert(out.end(), s.changed.begin(), s.changed.end());
  s.changed.clear();
  std::fill(s.is_changed.begin(), s.is_changed.end(), std::uint8_t{0});
}

}  // namespace typodont::debris
