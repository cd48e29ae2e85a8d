#include "haptics/contact/vertex/head_distances.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "engine/base/dispatch.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics::vertex {

namespace {

constexpr std::size_t kBatch = HeadDistances::kBatch;

/// Columns of eight points that are processed at once. Input: vectors from the head's centre to the points. Results:
/// signed distances from the head, and their gradients.
struct Lanes {
  double *x, *y, *z;
  double *distance, *n_x, *n_y, *n_z;
};

/// Computes distances of points from a ball, like VertexHead::distance(p, n).
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void evaluate_ball(double radius, std::size_t count, const Lanes& columns) {
  for (std::size_t k = 0; k < count; k += kBatch) {
    D8 x, y, z;
    read_lanes(x, columns.x + k), read_lanes(y, columns.y + k), read_lanes(z, columns.z + k);
    D8 length = x * x + y * y + z * z;
    take_root(length);
    const L8 off_center = length > 0.0;
    write_lanes(columns.distance + k, length - radius);
    write_lanes(columns.n_x + k, off_center ? x / length : D8{});
    write_lanes(columns.n_y + k, off_center ? y / length : D8{});
    write_lanes(columns.n_z + k, off_center ? z / length : D8{} - 1.0);
  }
}

/// Computes distances of points from a head with a meridian (not a ball), like HeadField::distance(p, n). `R`: T to W.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void evaluate_head(const HeadField::Piece* pieces, int piece_count, const double* R, std::size_t count,
                   const Lanes& columns) {
  const D8 zero = {};
  for (std::size_t k = 0; k < count; k += kBatch) {
    D8 wx, wy, wz;
    read_lanes(wx, columns.x + k), read_lanes(wy, columns.y + k), read_lanes(wz, columns.z + k);
    const D8 x = R[0] * wx + R[1] * wy + R[2] * wz, y = R[3] * wx + R[4] * wy + R[5] * wz,
             z = R[6] * wx + R[7] * wy + R[8] * wz;
    D8 rho = x * x + y * y;
    take_root(rho);
    D8 best2 = zero + 1e300, best_x = zero, best_z = zero, normal_x = zero, normal_z = zero;
    L8 outside = {};
    for (int i = 0; i < piece_count; ++i) {
      const HeadField::Piece& piece = pieces[i];
      const D8 ex = rho - piece.ax, ez = z - piece.az;
      const L8 beyond = piece.dx * ez - piece.dz * ex < 0.0;
      D8 fx, fz, nx, nz;
      if (piece.radius == 0) {
        D8 s = (ex * piece.dx + ez * piece.dz) * piece.inverse2;
        s = s < 0.0 ? zero : s;
        s = s > 1.0 ? zero + 1.0 : s;
        fx = ex - s * piece.dx, fz = ez - s * piece.dz;
        nx = zero + piece.dz, nz = -(zero + piece.dx);
        outside |= beyond;
      } else {
        const D8 vx = rho - piece.cx, vz = z - piece.cz, gx = rho - piece.bx, gz = z - piece.bz;
        D8 length = vx * vx + vz * vz;
        take_root(length);
        const double ux = piece.ax - piece.cx, uz = piece.az - piece.cz, tx = piece.bx - piece.cx,
                     tz = piece.bz - piece.cz;
        outside |= beyond & (length > piece.radius);
        const L8 between = (length > 0.0) & (ux * vz - uz * vx >= 0.0) & (vx * tz - vz * tx >= 0.0);
        const L8 first = ex * ex + ez * ez < gx * gx + gz * gz;
        const D8 f = 1.0 - piece.radius / length;
        fx = between ? vx * f : first ? ex : gx;
        fz = between ? vz * f : first ? ez : gz;
        nx = vx, nz = vz;
      }
      const D8 f2 = fx * fx + fz * fz;
      const L8 closer = f2 < best2;
      best2 = closer ? f2 : best2;
      best_x = closer ? fx : best_x, best_z = closer ? fz : best_z;
      normal_x = closer ? nx : normal_x, normal_z = closer ? nz : normal_z;
    }
    D8 length = best2, squared = normal_x * normal_x + normal_z * normal_z;
    take_root(length), take_root(squared);
    const D8 sign = outside ? zero + 1.0 : zero - 1.0;
    const L8 off_surface = length > 1e-9, known = squared > 0.0, off_axis = rho > 1e-12;
    const D8 n_rho = off_surface ? sign * best_x / length : known ? normal_x / squared : zero + 1.0;
    const D8 n_z = off_surface ? sign * best_z / length : known ? normal_z / squared : zero;
    const D8 n_x = off_axis ? n_rho * x / rho : n_rho, n_y = off_axis ? n_rho * y / rho : zero;
    write_lanes(columns.distance + k, sign * length);
    write_lanes(columns.n_x + k, R[0] * n_x + R[3] * n_y + R[6] * n_z);
    write_lanes(columns.n_y + k, R[1] * n_x + R[4] * n_y + R[7] * n_z);
    write_lanes(columns.n_z + k, R[2] * n_x + R[5] * n_y + R[8] * n_z);
  }
}

/// Distances of points from the head at one pose, from which find() extrapolates; read eight at a time.
struct KnownDistances {
  const float *x, *y, *z;  // m, positions in frame T
  const float* distance;
  const float *n_x, *n_y, *n_z;  // gradients in frame T
  std::size_t count;
};

/// Extrapolates distances after each point p has moved by change·p + shift in frame T. Stores distance (m) and index of
/// the points nearer than far (m) + max(0, motion · gradient). Returns their number.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
std::size_t extrapolate_near(const KnownDistances& known, const float* change, const float* shift, const float* motion,
                             float far, std::uint32_t* at, double* distance) {
  std::size_t found = 0;
  for (std::size_t k = 0; k < known.count; k += kBatch) {
    F8 x, y, z, d, nx, ny, nz;
    std::memcpy(&x, known.x + k, sizeof x), std::memcpy(&y, known.y + k, sizeof y);
    std::memcpy(&z, known.z + k, sizeof z), std::memcpy(&d, known.distance + k, sizeof d);
    std::memcpy(&nx, known.n_x + k, sizeof nx), std::memcpy(&ny, known.n_y + k, sizeof ny);
    std::memcpy(&nz, known.n_z + k, sizeof nz);
    d += nx * (change[0] * x + change[3] * y + change[6] * z + shift[0]) +
         ny * (change[1] * x + change[4] * y + change[7] * z + shift[1]) +
         nz * (change[2] * x + change[5] * y + change[8] * z + shift[2]);
    const F8 nearer = nx * motion[0] + ny * motion[1] + nz * motion[2];
    const I8 is_near = d - (nearer > 0.0f ? nearer : F8{}) <= far;
    for (unsigned bits = bits_of(is_near); bits; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      at[found] = static_cast<std::uint32_t>(k + lane);
      distance[found++] = static_cast<double>(d[lane]);
    }
  }
  // Removes entries for elements after the end, which the last batch of eight also reads.
  while (found > 0 && at[found - 1] >= known.count) --found;
  return found;
}

/// Rotates the gradients of the points with the indices `at` from T to W. `R`: column by column.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void rotate_gradients(const KnownDistances& known, const double* R, std::size_t count, const std::uint32_t* at,
                      const Lanes& columns) {
  for (std::size_t k = 0; k < count; k += kBatch) {
    D8 x, y, z;
    for (std::size_t i = 0; i < kBatch; ++i) {
      const std::uint32_t p = at[k + i];
      x[i] = static_cast<double>(known.n_x[p]), y[i] = static_cast<double>(known.n_y[p]);
      z[i] = static_cast<double>(known.n_z[p]);
    }
    write_lanes(columns.n_x + k, R[0] * x + R[3] * y + R[6] * z);
    write_lanes(columns.n_y + k, R[1] * x + R[4] * y + R[7] * z);
    write_lanes(columns.n_z + k, R[2] * x + R[5] * y + R[8] * z);
  }
}

}  // namespace

HeadDistances::HeadDistances(std::size_t most, double reuse) : most_(most), reuse_(reuse) {
  for (auto* column : {&x_, &y_, &z_, &distance_, &n_x_, &n_y_, &n_z_}) column->resize(most + kBatch);
  index_.resize(most + kBatch);
  if (!(reuse > 0)) return;
  for (auto* column : {&p_x_, &p_y_, &p_z_, &d_, &g_x_, &g_y_, &g_z_}) column->resize(most + kBatch);
}

void HeadDistances::find(const VertexHead& head, mesh::NearPoints& points, const Pose& X_WG, double far,
                         bool exact) noexcept {
  if (reuse_ > 0 && !exact) {
    know(head, points, X_WG);
    return extrapolate(X_WG, far, dvec3(0));
  }
  // If the head is not a ball, skips points whose listed distance exceeds `far` + the motion since the list was made.
  const std::span<const std::uint32_t> listed =
      head.is_ball() ? points.within(X_WG.p, head.reach() + far)
                     : points.listed_within(far + displacement_bound(points.listed_at(), X_WG, head.reach()));
  clear();
  for (const std::uint32_t i : listed) add(i, points[i] - X_WG.p);
  evaluate(head, glm::dmat3(glm::mat3_cast(X_WG.R)), far);
}

void HeadDistances::find_pushed(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG,
                                const dvec3& motion_W) noexcept {
  know(head, points, X_WG);
  extrapolate(X_WG, 0, motion_W);
}

/// Computes the distances from which find() extrapolates, unless they were computed for this list at a pose near X_WG.
void HeadDistances::know(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG) noexcept {
  if (known_list_ == points.number() && known_ == points.size() &&
      displacement_bound(known_at_, X_WG, head.reach()) <= reuse_ * head.radius()) {
    return;
  }
  compute_all(head, points, X_WG);
}

/// Computes and stores the distances of all listed points from a head at X_WG.
void HeadDistances::compute_all(const VertexHead& head, const mesh::NearPoints& points, const Pose& X_WG) noexcept {
  const glm::dmat3 R_WT(glm::mat3_cast(X_WG.R)), R_TW = glm::transpose(R_WT);
  clear();
  for (std::size_t i = 0; i < points.size(); ++i) add(static_cast<std::uint32_t>(i), points[i] - X_WG.p);
  evaluate(head, R_WT, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < size_; ++i) {
    const glm::vec3 p(R_TW * dvec3(x_[i], y_[i], z_[i])), n(R_TW * normal_W(i));
    p_x_[i] = p.x, p_y_[i] = p.y, p_z_[i] = p.z;
    g_x_[i] = n.x, g_y_[i] = n.y, g_z_[i] = n.z;
    d_[i] = static_cast<float>(distance_[i]);
  }
  known_list_ = points.number(), known_ = points.size(), known_at_ = X_WG;
  computed_ += size_;
}

/// Extrapolates distances to the pose X_WG. Keeps points within `far` (m) of the head after its motion `motion_W` (m).
void HeadDistances::extrapolate(const Pose& X_WG, double far, const dvec3& motion_W) noexcept {
  const glm::dmat3 R_WT(glm::mat3_cast(X_WG.R)), R_TW = glm::transpose(R_WT);
  const glm::mat3 change(R_TW * glm::dmat3(glm::mat3_cast(known_at_.R)) - glm::dmat3(1));
  const glm::vec3 shift(R_TW * (known_at_.p - X_WG.p)), motion(R_TW * motion_W);
  const KnownDistances known{p_x_.data(), p_y_.data(), p_z_.data(), d_.data(),
                             g_x_.data(), g_y_.data(), g_z_.data(), known_};
  size_ = extrapolate_near(known, &change[0][0], &shift.x, &motion.x, static_cast<float>(far), index_.data(),
                           distance_.data());
  // The last batch of eight also reads these unused indices.
  for (std::size_t i = size_; i < size_ + kBatch; ++i) index_[i] = 0;
  rotate_gradients(known, &R_WT[0][0], size_, index_.data(),
                   {x_.data(), y_.data(), z_.data(), distance_.data(), n_x_.data(), n_y_.data(), n_z_.data()});
}

void HeadDistances::keep_within(const VertexHead& head, mesh::NearPoints& points, std::size_t first,
                                double far) noexcept {
  const Pose& X = points.listed_at();
  const glm::dmat3 R_WT(glm::mat3_cast(X.R));
  const glm::vec3 axis(R_WT[2]);
  const auto within = static_cast<float>(far);
  clear();
  for (std::size_t i = first; i < points.size(); ++i) {
    const dvec3 off = points[i] - X.p;
    if (head.may_be_within(glm::vec3(off), axis, within)) add(static_cast<std::uint32_t>(i), off);
  }
  evaluate(head, R_WT, far);
  points.keep(first, kept(), {distance_.data(), size_});
}

void HeadDistances::evaluate(const VertexHead& head, const glm::dmat3& R_WT, double far) noexcept {
  const std::size_t count = size_;
  // The last batch of eight also reads these unused elements.
  for (std::size_t k = count; k < count + kBatch; ++k) x_[k] = y_[k] = z_[k] = 0;
  const Lanes columns{x_.data(), y_.data(), z_.data(), distance_.data(), n_x_.data(), n_y_.data(), n_z_.data()};
  if (head.is_ball()) {
    evaluate_ball(head.radius(), count, columns);
  } else {
    evaluate_head(head.field().pieces, head.field().count, &R_WT[0][0], count, columns);
  }
  size_ = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (!(distance_[k] <= far)) continue;
    index_[size_] = index_[k], distance_[size_] = distance_[k];
    n_x_[size_] = n_x_[k], n_y_[size_] = n_y_[k], n_z_[size_] = n_z_[k];
    ++size_;
  }
}

}  // namespace typodont::haptics::vertex
