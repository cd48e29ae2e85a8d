#include "haptics/cutting/meridian.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

namespace typodont::haptics {

void flatten(const HeadField& head, MeridianPiece* pieces) {
  for (int p = 0; p < head.count; ++p) {
    const HeadField::Piece& piece = head.pieces[p];
    const double length = std::sqrt(1 / piece.inverse2), r = piece.radius;
    const bool line = r == 0;
    const double values[] = {piece.ax,
                             piece.az,
                             piece.bx,
                             piece.bz,
                             piece.dx,
                             piece.dz,
                             piece.inverse2,
                             piece.cx,
                             piece.cz,
                             r,
                             line ? piece.dz / length : (piece.ax - piece.cx) / r,
                             line ? -piece.dx / length : (piece.az - piece.cz) / r,
                             line ? piece.dz / length : (piece.bx - piece.cx) / r,
                             line ? -piece.dx / length : (piece.bz - piece.cz) / r,
                             length,
                             piece.ax - piece.cx,
                             piece.az - piece.cz,
                             piece.bx - piece.cx,
                             piece.bz - piece.cz,
                             0,
                             0};
    static_assert(sizeof(MeridianPiece) == std::size(values) * sizeof(float));
    float flat[std::size(values)];
    for (std::size_t i = 0; i < std::size(values); ++i) flat[i] = static_cast<float>(values[i]);
    std::memcpy(&pieces[p], flat, sizeof flat);
  }
  for (int p = 0; p + 1 < head.count; ++p) {
    const float c = std::clamp(pieces[p].nbx * pieces[p + 1].nax + pieces[p].nbz * pieces[p + 1].naz, -1.0f, 1.0f);
    pieces[p].corner_b = pieces[p + 1].corner_a = std::min(std::sqrt((1 - c) / (1 + c)), kNoEnd);
  }
}

HeadPose head_pose(const Pose& X_VT) {
  HeadPose pose;
  pose.base = glm::ivec3(glm::floor(X_VT.p));
  const glm::vec3 p(X_VT.p - dvec3(pose.base));
  const glm::mat3 R(glm::transpose(glm::dmat3(X_VT.R)));
  for (int i = 0; i < 3; ++i) pose.p[i] = p[i];
  for (int i = 0; i < 9; ++i) pose.R[i] = R[i / 3][i % 3];
  return pose;
}

}  // namespace typodont::haptics
