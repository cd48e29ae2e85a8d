#include "engine/app/surroundings/jaw.h"

#include <algorithm>
#include <cmath>

#include "engine/app/tissue/blend.h"

namespace typodont {

namespace {

constexpr double kFree = 0.5e-3;          // m, height of the gum's edge above a tooth's neck
constexpr double kPapillaWidth = 1.8e-3;  // m, width of a papilla, the gum between two teeth
// Distances along the arch from the working tooth, m. Up to the first
// distance, the gum's edge is tilted; from the second on, it is level.
constexpr double kTiltFrom = 6e-3, kTiltTo = 10e-3;
// Distances from the arch's curve, m: the gum's edge follows the teeth up to kEdgeTo, and is level from kEvenFrom on.
constexpr double kEdgeTo = 6e-3, kEvenFrom = 12e-3;
constexpr double kRowDepth = 15.5e-3;  // m, thickness of a jaw with a row of teeth
constexpr double kBlockDepth = 9e-3;   // m, smallest thickness of a jaw without teeth
// The alveolar ridge, m: depth of its top below the gum's edge, distance of its side
// from the teeth, its widening towards cheek and tongue, depth over which it widens.
constexpr double kRidgeTop = 1.3e-3, kRidgeRim = 0.5e-3, kBuccalSwell = 1.7e-3, kLingualSwell = 1.1e-3,
                 kSwellDepth = 4e-3;
// m: depths of the folds beside the ridge, radius of the folds, half the width of a jaw without cheek and tongue.
constexpr double kBuccalFold = 8.5e-3, kLingualFold = 9.5e-3, kFoldRound = 5e-3, kJawEdge = 13.5e-3;
constexpr double kBack = 25e-3;  // m, distance from the working tooth to the back of the mouth
// m: width of the attached gum; half the width of the transition from this gum to the mucosa.
constexpr double kAttached = 4.4e-3, kLine = 0.5e-3;
// The tongue, m: distance from the teeth, depth of its edge below the chewing plane, height of its dome, edge radius.
constexpr double kTongueFrom = 9.0e-3, kTongueBelow = 3.5e-3, kTongueDome = 5.5e-3, kTongueRound = 6e-3;
// Cheek and lip, m: distance of the cheek from the teeth, height of the cheek's edge above
// the chewing plane, depth of the lip's edge below this plane, radius of both edges.
constexpr double kCheekFrom = 11.5e-3, kCheekOver = 6.5e-3, kLipBelow = 1.5e-3, kCheekRound = 7e-3;
// The face, m: distance of the lip and of the face's end from the teeth, radius of the
// lip, drop of the face (1/m) per squared distance from the lip, thickness of the face.
constexpr double kLipFrom = 18e-3, kLipRadius = 3.4e-3, kFaceTo = 36e-3, kFaceFall = 14, kFaceThick = 4e-3;
// Height of the lip above the mouth's rim, and depth of the face below this rim, m.
constexpr double kLipOver = 0.4e-3, kFaceBelow = 1.6e-3;

}  // namespace

Jaw::Jaw(const SurroundingsPlan& plan, const dvec3& middle, double half_width, double occlusal, double roots)
    : plan_(plan), across_(glm::cross(plan.crown, plan.arch)), occlusal_(occlusal) {
  const dvec3 own = to_row(middle), edge = to_row(plan.margin);
  if (plan.row) {
    curve_ = ArchCurve(plan.row->curve);
  } else {
    const double half = std::max(plan.length / 2 - half_width, 1e-3);
    curve_ = ArchCurve({{own.x - half, own.y}, {own.x + half, own.y}});
  }
  const auto at = curve_.place({own.x, own.y});
  own_ = at.along;
  beside_ = curve_.place({edge.x, edge.y}).beside;
  const dvec3 n = {glm::dot(plan.margin_normal, plan.arch), glm::dot(plan.margin_normal, across_),
                   glm::dot(plan.margin_normal, plan.crown)};
  tilt_along_ = -n.x / n.z;
  tilt_beside_ = -n.y / n.z;
  own_edge_ = edge.z;
  knots_.push_back({own_, edge.z - tilt_along_ * (edge.x - own.x), half_width});
  depth_ = plan.row ? kRowDepth : std::max(kBlockDepth, roots + 1.5e-3);
  own_x_ = own.x;
  back_ = own.x - kBack;
  if (plan.row) {
    for (const RowTooth& tooth : plan.row->teeth)
      knots_.push_back({curve_.place({tooth.at.x, tooth.at.y}).along, tooth.at.z + kFree, 0.5 * tooth.form.neck.y});
    std::sort(knots_.begin(), knots_.end(), [](const Knot& a, const Knot& b) { return a.along < b.along; });
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i)
      contacts_.push_back(0.5 * (knots_[i].along + knots_[i + 1].along));
  }
  for (const NeighbourTooth& tooth : plan.neighbours) {
    const dvec3 contact = to_row(tooth.contact);
    contacts_.push_back(curve_.place({contact.x, contact.y}).along);
  }
}

Jaw::Place Jaw::place(const dvec3& p_W) const {
  const dvec3 p = to_row(p_W);
  const auto at = curve_.place({p.x, p.y});
  Knot here = knots_.front();
  if (at.along >= knots_.back().along) {
    here = knots_.back();
  } else if (at.along > here.along) {
    std::size_t i = 0;
    while (knots_[i + 1].along < at.along) ++i;
    const Knot &a = knots_[i], &b = knots_[i + 1];
    const double t = smooth_step(0.25, 0.75, (at.along - a.along) / (b.along - a.along));
    here = {at.along, a.edge + t * (b.edge - a.edge), a.half_width + t * (b.half_width - a.half_width)};
  }
  const double from_own = at.along - own_;
  const double near = plan_.row ? 1 - smooth_step(kTiltFrom, kTiltTo, std::abs(from_own)) : 1;
  const double tilt = near * (tilt_along_ * from_own + tilt_beside_ * std::clamp(at.beside - beside_, -8e-3, 8e-3));
  // Far from the teeth, the nearest tooth can change abruptly, so the gum's edge has a constant height there.
  const double far = plan_.row ? smooth_step(kEdgeTo, kEvenFrom, std::abs(at.beside)) : 0;
  const double edge = here.edge + tilt + far * (own_edge_ - here.edge - tilt);
  return {at.along, at.beside, edge - p.z, here.half_width, p.x, p.z};
}

double Jaw::papilla(const Place& p) const {
  double raise = 0;
  for (const double contact : contacts_) {
    const double away = (p.along - contact) / kPapillaWidth;
    if (std::abs(away) < 4) raise = std::max(raise, plan_.papilla * std::exp(-away * away));
  }
  return raise;
}

double Jaw::mucosa(const Place& p) const {
  const double wave = 0.35e-3 * std::sin(p.along * 1100) + 0.25e-3 * std::sin(p.along * 2300 + 1);
  const double below = smooth_step(kAttached - kLine, kAttached + kLine, p.depth + wave);
  const double edge = 0.3 * (1 - smooth_step(0, 0.8e-3, p.depth + papilla(p)));
  return std::max(below, edge);
}

double Jaw::ridge(const Place& p) const {
  const double down = std::max(p.depth, 0.0);
  const double swell = (p.beside > 0 ? kBuccalSwell : kLingualSwell) * (1 - std::exp(-down / kSwellDepth));
  const double side = std::abs(p.beside) - p.half_width - kRidgeRim - swell;
  // Adds the papillae between the teeth.
  const double raise = papilla(p), between = plan_.papilla > 0 ? raise / plan_.papilla : 0;
  double d = smooth_max(side, kRidgeTop * (1 - between) - p.depth - raise, 4e-3 - 2.2e-3 * between);
  if (plan_.row) {
    d = smooth_min(d, (p.beside > 0 ? kBuccalFold : kLingualFold) - p.depth, kFoldRound);
    // The floor ends at the jaw's edge, or inside cheek and lip.
    const double beyond = plan_.mouth == Mouth::kNone ? std::abs(p.beside) - kJawEdge : from_curve(p) - kLipFrom;
    d = smooth_max(d, beyond, 2e-3);
  }
  if (plan_.row) d = smooth_max(d, back_ - 3e-3 - p.x, 2e-3);
  return smooth_max(d, p.depth - depth_, 2e-3);
}

double Jaw::tongue(const Place& p) const {
  const double in = -p.beside - kTongueFrom;
  const double top = occlusal_ - kTongueBelow + kTongueDome * (1 - std::exp(-std::max(in, 0.0) / 9e-3));
  const double d = smooth_max(-in, p.z - top, kTongueRound);
  return std::max({d, p.depth - depth_, back_ - 3e-3 - p.x});
}

double Jaw::rim(const Place& p) const {
  // The cheek is high beside the molars; the lip in front is low.
  const double front = smooth_step(14e-3, 30e-3, p.x - own_x_);
  return occlusal_ + kCheekOver - front * (kLipBelow + kCheekOver);
}

double Jaw::from_curve(const Place& p) const {
  // The cheek closes the mouth behind the last tooth.
  return smooth_max(p.beside, back_ + kCheekFrom - p.x, 8e-3);
}

double Jaw::cheek(const Place& p) const {
  const double out = from_curve(p);
  return smooth_max(smooth_max(kCheekFrom - out, p.z - rim(p), kCheekRound), out - kLipFrom, 1e-3);
}

double Jaw::lip(const Place& p) const {
  return std::hypot(from_curve(p) - kLipFrom, p.z - rim(p) + kLipRadius - kLipOver) - kLipRadius;
}

double Jaw::face(const Place& p) const {
  const double out = from_curve(p) - kLipFrom;
  const double top = rim(p) - kFaceBelow - kFaceFall * out * out;
  const double d = smooth_max(smooth_max(-out, p.z - top, 1e-3), out + kLipFrom - kFaceTo, 3e-3);
  return std::max(d, top - kFaceThick - p.z);
}

}  // namespace typodont
