// Tests meshes as clinics have them: overlapping shells, very narrow gaps, copies, holes, and one file per tissue.
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>
#include <set>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/import/import.h"
#include "haptics/import/import_scan.h"
#include "haptics/import/mesh_solid.h"
#include "tests/support/import_message.h"
#include "tests/support/import_phantom.h"

namespace typodont::haptics {
namespace {

using test::message_of;
using test::scratch;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

struct Soup {
  std::vector<std::array<dvec3, 3>> triangles;  // mm

  void add(const Soup& other) { triangles.insert(triangles.end(), other.triangles.begin(), other.triangles.end()); }
  Soup inside_out() const {
    Soup s = *this;
    for (auto& t : s.triangles) std::swap(t[1], t[2]);
    return s;
  }
  std::filesystem::path write(const std::string& name) const {
    std::string s = "solid s\n";
    for (const auto& t : triangles) {
      s += "facet normal 0 0 0\nouter loop\n";
      for (const dvec3& p : t) s += fmt::format("vertex {:.9g} {:.9g} {:.9g}\n", p.x, p.y, p.z);
      s += "endloop\nendfacet\n";
    }
    test::write(scratch(name), s + "endsolid\n");
    return scratch(name);
  }
};

Soup box(const dvec3& lo, const dvec3& hi) {
  const auto at = [&](int k) { return dvec3(k & 1 ? hi.x : lo.x, k & 2 ? hi.y : lo.y, k & 4 ? hi.z : lo.z); };
  const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {1, 3, 7, 5}, {3, 2, 6, 7}, {2, 0, 4, 6}};
  Soup s;
  for (const auto& q : quads) {
    s.triangles.push_back({at(q[0]), at(q[1]), at(q[2])});
    s.triangles.push_back({at(q[0]), at(q[2]), at(q[3])});
  }
  return s;
}

/// A ball of latitudes and longitudes.
Soup ball(const dvec3& center, double radius, int rings = 32) {
  Soup s;
  const auto at = [&](int i, int j) {
    const double a = kPi * i / rings, b = kPi * j / rings;
    const dvec3 p = center + radius * dvec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
    return 1e-6 * glm::round(1e6 * p);  // the first meridian is the last one
  };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < 2 * rings; ++j) {
      if (i > 0) s.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < rings) s.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  }
  return s;
}

ImportOptions bone(double voxel_mm = 0.2) {
  ImportOptions o;
  o.preset = ImportPreset::kBone;
  o.voxel = voxel_mm * kMillimetre;
  return o;
}
double total(const Imported& i) {
  return typodont::total(i.report.volume) / kCubicMillimetre;
}
double volume(const Imported& i, Tissue t) {
  return i.report.volume[static_cast<std::size_t>(t)] / kCubicMillimetre;
}
float distance_at(const DenseTissue& t, const dvec3& mm) {
  const glm::ivec3 p(glm::round(t.frame.to_voxels(mm * kMillimetre)));
  return t.distance[t.at(p.x, p.y, p.z)];
}
Tissue tissue_at(const DenseTissue& t, const dvec3& mm) {
  const glm::ivec3 p(glm::round(t.frame.to_voxels(mm * kMillimetre)));
  return t.tissue[t.at(p.x, p.y, p.z)];
}
/// Returns a PLY file of these points and faces as text. `colors`: a point has a colour
std::string ply_of(int points, int faces, const std::string& data, bool colors = false) {
  return fmt::format(
             "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float "
             "z\n{}element "
             "face {}\nproperty list uchar int vertex_indices\nend_header\n",
             points, colors ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "", faces) +
         data;
}
double sphere(double r) {
  return 4 * kPi / 3 * r * r * r;
}

TEST(ImportShells, OverlappingShellsAreUnitedForAnyOrientation) {
  constexpr double h = 2;  // of the two caps that two balls of radius 5, 6 apart, share
  const double both = 2 * sphere(5) - 2 * kPi * h * h * (5 - h / 3);
  for (const bool turned : {false, true}) {
    SCOPED_TRACE(turned);
    Soup s = ball({0, 0, 0}, 5);
    const Soup other = ball({6, 0, 0}, 5);
    s.add(turned ? other.inside_out() : other);
    const Imported i = import_tissue(s.write("overlap.stl"), bone());
    EXPECT_NEAR(total(i) / both, 1, 0.006);  // 32 rings are 0.4 % short of a ball
    EXPECT_EQ(i.report.bodies_kept, 1);
  }
}

TEST(ImportShells, DistanceInTheOverlapIsThatToTheUnionsSurface) {
  // Two boxes overlap. Their triangles are large, and half of each triangle is within the other box.
  Soup s = box({0, 0, 0}, {10, 6, 6});
  s.add(box({5, 0, 0}, {15, 6, 6}));
  const Imported i = import_tissue(s.write("boxes.stl"), bone());
  for (double x = 2; x < 13; x += 0.5) {
    for (const double y : {1.0, 2.4})
      EXPECT_NEAR(distance_at(i.tissue, {x, y, 3}) / kMillimetre, -std::min(y, 1.5), 0.11) << x << " " << y;
  }
}

TEST(ImportShells, ASolidOfOverlappingShellsIsTheirUnion) {
  Soup s = box({0, 0, 0}, {4, 4, 4});
  s.add(box({2, 1, 1}, {7, 3, 3}).inside_out());
  s.add(box({0.5, 0.5, 0.5}, {1.5, 1.5, 1.5}));  // wholly within: a hollow
  const auto solid = read_mesh_solid(s.write("solid.stl"), 1e-3);
  EXPECT_LT(solid->distance(dvec3(3, 2, 2) * kMillimetre), 0);
  EXPECT_LT(solid->distance(dvec3(6, 2, 2) * kMillimetre), 0);
  EXPECT_GT(solid->distance(dvec3(1, 1, 1) * kMillimetre), 0);
  EXPECT_GT(solid->distance(dvec3(6, 0.5, 2) * kMillimetre), 0);
}

TEST(ImportShells, DistancesOfManyPointsHaveTheBitsOfSingleDistances) {
  Soup s = box({0, 0, 0}, {4, 4, 4});
  s.add(box({2, 1, 1}, {7, 3, 3}).inside_out());
  s.add(ball({0.5, 2, 4}, 1.7));
  const auto solid = read_mesh_solid(s.write("many.stl"), 1e-3);
  // Small steps, between which the sign need not be computed again, and jumps across the surface.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-3, 9), step(-0.2, 0.2);
  std::vector<dvec3> points;
  for (int i = 0; i < 20000; ++i) {
    const bool jump = i % 50 == 0;
    const auto draw = [&] { return jump ? anywhere(random) : step(random); };
    points.push_back((jump ? dvec3(0) : points.back()) + dvec3(draw(), draw(), draw()) * kMillimetre);
  }
  std::vector<double> distances(points.size());
  solid->distances(points, distances);
  std::size_t inside = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(distances[i], solid->distance(points[i])) << i;
    inside += distances[i] < 0 ? 1 : 0;
  }
  EXPECT_GT(inside, points.size() / 50);
  EXPECT_LT(inside, points.size() / 2);
}

TEST(ImportRepair, NearlyEqualVerticesAreMergedWithAMessage) {
  Soup s = ball({0, 0, 0}, 5);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-5e-6, 5e-6);
  for (auto& t : s.triangles)
    for (dvec3& p : t) p += dvec3(off(random), off(random), off(random));
  const Imported i = import_tissue(s.write("hair.stl"), bone());
  EXPECT_NEAR(total(i) / sphere(5), 1, 0.006);
  EXPECT_THAT(i.report.repairs, testing::Contains(HasSubstr("welded")));
}

TEST(ImportRepair, DuplicateAndFlippedTrianglesAndSmallHolesAreRepairedWithAMessage) {
  const Soup whole = ball({0, 0, 0}, 5);
  EXPECT_THAT(import_tissue(whole.write("whole.stl"), bone()).report.repairs, IsEmpty());
  Soup s = whole;
  for (std::size_t k = 0; k < 40; ++k) s.triangles.push_back(s.triangles[k * 31]);
  for (std::size_t k = 311; k < 341; ++k) std::swap(s.triangles[k][1], s.triangles[k][2]);
  s.triangles.erase(s.triangles.begin() + 1200);
  const Imported i = import_tissue(s.write("broken.stl"), bone());
  EXPECT_NEAR(total(i) / total(import_tissue(whole.write("whole.stl"), bone())), 1, 1e-3);
  EXPECT_THAT(i.report.repairs, testing::Contains(HasSubstr("second copies of triangles")));
  EXPECT_THAT(i.report.repairs, testing::Contains(HasSubstr("30 triangles turned")));
  EXPECT_THAT(i.report.repairs, testing::Contains(HasSubstr("1 small holes with 3 edges closed")));
}

TEST(ImportRepair, TheReportContainsThePlacesOfRepairsAndThePictureMarksThem) {
  const Soup whole = ball({0, 0, 0}, 5);
  EXPECT_THAT(import_tissue(whole.write("whole.stl"), bone()).report.repaired, IsEmpty());
  Soup s = whole;
  const std::array<dvec3, 3> removed = s.triangles[1200], turned = s.triangles[400], copied = s.triangles[900];
  std::swap(s.triangles[400][1], s.triangles[400][2]);
  s.triangles.push_back(copied);
  s.triangles.erase(s.triangles.begin() + 1200);
  ImportOptions options = bone();
  options.turn = quarter_turns("x90");
  Imported i = import_tissue(s.write("broken.stl"), options);
  // The points of the result are the corners and centres of the three triangles, and no other points.
  std::set<std::size_t> found;
  const std::array<std::array<dvec3, 3>, 3> repaired{removed, turned, copied};
  for (const dvec3& p : i.report.repaired) {
    for (std::size_t k = 0; k < repaired.size(); ++k) {
      std::vector<dvec3> points(repaired[k].begin(), repaired[k].end());
      points.push_back((points[0] + points[1] + points[2]) / 3.0);
      for (const dvec3& q : points)
        if (glm::length(options.turn * q - p / kMillimetre) < 1e-3) found.insert(k);
    }
    EXPECT_NEAR(glm::length(p) / kMillimetre, 5, 0.1);
  }
  EXPECT_EQ(found.size(), 3U);
  EXPECT_EQ(i.report.repaired.size(), 12U);
  // The picture of the repaired ball has other colours than the picture without the marks.
  const auto surface = [&](const char* folder) { return test::read_text(write_preview(i, scratch(folder)).back()); };
  const std::string marked = surface("marked");
  i.report.repaired.clear();
  EXPECT_NE(marked, surface("unmarked"));
}

TEST(ImportRepair, ALargeHoleIsRefusedWithItsSize) {
  Soup s = ball({0, 0, 0}, 5);
  std::erase_if(s.triangles, [](const auto& t) { return t[0].z > 4 && t[1].z > 4 && t[2].z > 4; });
  EXPECT_THAT(message_of(s.write("open.stl"), bone()),
              AllOf(HasSubstr("open edges around 1 holes"), HasSubstr("border of"), HasSubstr("a closed surface")));
}

TEST(ImportParts, OneFilePerTissueGivesEachItsOwnLabel) {
  ImportOptions o;
  o.voxel = 0.1e-3;
  o.parts = {{Tissue::kEnamel, ball({0, 0, 0}, 4).write("enamel.stl")},
             {Tissue::kDentin, ball({0, 0, 0}, 3).write("dentin.stl")},
             {Tissue::kPulp, ball({0, 0, 0}, 1).write("pulp.stl")}};
  const Imported i = import_tissue("", o);
  EXPECT_NEAR(volume(i, Tissue::kEnamel) / (sphere(4) - sphere(3)), 1, 0.02);
  EXPECT_NEAR(volume(i, Tissue::kDentin) / (sphere(3) - sphere(1)), 1, 0.02);
  EXPECT_NEAR(volume(i, Tissue::kPulp) / sphere(1), 1, 0.05);
  EXPECT_EQ(i.report.bodies_kept, 1);
  // Deep in the tissue, the distance must not depend on the surface that separates single tissues.
  EXPECT_NEAR(distance_at(i.tissue, {3, 0, 0}), -1e-3, 0.05e-3);
}

TEST(ImportParts, APartThatLaterOnesCoverWhollyIsRefused) {
  ImportOptions o = bone();
  o.parts = {{Tissue::kDentin, ball({0, 0, 0}, 3).write("dentin.stl")},
             {Tissue::kEnamel, ball({0, 0, 0}, 4).write("enamel.stl")}};
  EXPECT_THAT(message_of("", o), AllOf(HasSubstr("--part"), HasSubstr("no voxel of dentin"), HasSubstr("outermost")));
}

TEST(ImportParts, AGapBetweenTwoPartsIsClosed) {
  ImportOptions o = bone(0.1);
  o.parts = {{Tissue::kCorticalBone, box({0, 0, 0}, {4.03, 6, 6}).write("left.stl")},
             {Tissue::kCancellousBone, box({4.06, 0, 0}, {8, 6, 6}).write("right.stl")}};
  const Imported i = import_tissue("", o);
  EXPECT_EQ(i.report.bodies_kept, 1);
  EXPECT_NEAR(total(i) / (8 * 36), 1, 5e-3);
  EXPECT_NEAR(distance_at(i.tissue, {4.05, 3, 3}), -1.5e-3, 1e-6);
}

TEST(ImportParts, TissuesInOneFileAreRefusedAndTheRemedyNamed) {
  Soup s = ball({0, 0, 0}, 4);
  s.add(ball({0, 0, 0}, 3));
  EXPECT_THAT(message_of(s.write("two.stl"), {}), AllOf(HasSubstr("shells of 1"), HasSubstr("--part enamel=FILE")));
  s.add(ball({0, 0, 0}, 1));
  EXPECT_THAT(message_of(s.write("three.stl"), {}), AllOf(HasSubstr("a shell within a shell"), HasSubstr("--part")));
  // A pulp that is a small part of the tooth is accepted as pulp.
  Soup tooth = ball({0, 0, 0}, 4);
  tooth.add(ball({0, 0, 0}, 1.5));
  ImportOptions o;
  o.voxel = 0.1e-3;
  EXPECT_NEAR(volume(import_tissue(tooth.write("tooth.stl"), o), Tissue::kPulp) / sphere(1.5), 1, 0.04);
}

TEST(ImportTurn, QuarterTurnsMoveTheBodyAndKeepItsHandedness) {
  // A body with three different arms differs from its mirror image.
  Soup s = box({0, 0, 0}, {9, 2, 2});
  s.add(box({0, 0, 0}, {2, 6, 2}));
  s.add(box({0, 0, 0}, {2, 2, 4}));
  const auto file = s.write("arms.stl");
  const Imported plain = import_tissue(file, bone());
  ImportOptions o = bone();
  o.turn = quarter_turns("x180");
  const Imported down = import_tissue(file, o);
  EXPECT_NEAR(total(down), total(plain), 1e-6);
  EXPECT_LT(glm::length(down.report.lo / kMillimetre - dvec3(0, -6, -4)), 0.05);
  EXPECT_LT(glm::length(down.report.hi / kMillimetre - dvec3(9, 0, 0)), 0.05);
  for (const char* text : {"x90", "y-90", "z90,x180", "x90,y90,z90"}) {
    SCOPED_TRACE(text);
    const glm::dmat3 r = quarter_turns(text);
    EXPECT_NEAR(glm::determinant(r), 1, 1e-12);
    o.turn = r;
    const Imported turned = import_tissue(file, o);
    EXPECT_EQ(turned.report.world_rotation, glm::transpose(r));
    for (const dvec3& mm : {dvec3(8, 1, 1), dvec3(1, 5, 1), dvec3(1, 1, 3.4), dvec3(5, 5, 1), dvec3(1, 5, 3.4)})
      EXPECT_NEAR(distance_at(plain.tissue, mm), distance_at(turned.tissue, r * mm), 1e-5);
  }
  for (const char* wrong : {"x45", "", "x90,"}) EXPECT_THROW(quarter_turns(wrong), Error) << wrong;
}

/// A quarter of a dental arch: a ridge along a quarter of a circle with three crowns on it and a ragged border.
/// Functions give the heights in mm above a plane, and the position where the gum ends.
struct Arch {
  static constexpr double kRadius = 20, kHalf = 7, kNeck = 9;  // mm
  static double height(double angle, double across) {
    const double w = across / kHalf, ridge = 8 * (1 - w * w);
    const double tooth = std::cos(6 * angle) * std::cos(6 * angle);
    const double crown = 9 * std::min(1.0, 1.6 * tooth) * std::exp(-std::pow(std::abs(across) / 4.2, 6));
    return ridge + crown;
  }
  struct Point {
    dvec3 p;
    bool gum;
  };
  static Point at(double angle, double across) {
    const double r = kRadius + across, z = height(angle, across);
    return {{r * std::cos(angle), r * std::sin(angle), z}, z < kNeck};
  }
  /// Returns the arch as a PLY file with its triangles, and with colours if `colors` is true. `scale`: units per mm.
  static std::string ply(double scale, bool colors, bool turned) {
    constexpr int kAlong = 160, kAcross = 60;
    std::string points, faces;
    int count = 0;
    for (int i = 0; i <= kAlong; ++i) {
      for (int j = 0; j <= kAcross; ++j) {
        // The border is ragged.
        const double ragged = j == 0 || j == kAcross ? 0.25 * std::sin(1.7 * i) : 0;
        const Point q = at(kPi / 2 * i / kAlong, kHalf * (2.0 * j / kAcross - 1) * (0.96 + 0.04 * ragged));
        points += fmt::format("{} {} {}", scale * q.p.x, scale * q.p.y, scale * q.p.z);
        points += colors ? q.gum ? " 190 90 95\n" : " 225 220 200\n" : "\n";
      }
    }
    const auto face = [&](int a, int b, int c) {
      faces += turned ? fmt::format("3 {} {} {}\n", a, c, b) : fmt::format("3 {} {} {}\n", a, b, c);
      ++count;
    };
    for (int i = 0; i < kAlong; ++i) {
      for (int j = 0; j < kAcross; ++j) {
        if (i == 40 && j == 30) continue;  // a small hole
        const int a = i * (kAcross + 1) + j, b = a + kAcross + 1;
        face(a, a + 1, b);
        face(a + 1, b + 1, b);
      }
    }
    // A small separate piece that the scanner recorded.
    const int n = (kAlong + 1) * (kAcross + 1);
    points += colors ? "0 0 0 9 9 9\n0 0.01 0 9 9 9\n0.01 0 0 9 9 9\n" : "0 0 0\n0 0.01 0\n0.01 0 0\n";
    face(n, n + 1, n + 2);
    return ply_of(n + 3, count, points + faces, colors);
  }
  /// Returns the volume (mm³) between the surface and a plane at `below` under 0.
  static double volume(double below) {
    double sum = 0;
    constexpr int kSteps = 400;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double angle = kPi / 2 * (i + 0.5) / kSteps, across = 0.96 * kHalf * (2 * (j + 0.5) / kSteps - 1);
        sum += (height(angle, across) + below) * (kRadius + across) * (kPi / 2 / kSteps) * (0.96 * 2 * kHalf / kSteps);
      }
    }
    return sum;
  }
};

ImportOptions arch_options() {
  ImportOptions o;
  o.preset = ImportPreset::kArch;
  o.voxel = 0.2e-3;
  return o;
}

TEST(ImportArch, AnOpenScanIsClosedWithABaseAndItsTissuesAreFoundByColour) {
  for (const bool turned : {false, true}) {
    SCOPED_TRACE(turned);
    test::write(scratch("arch.ply"), Arch::ply(1, true, turned));
    const Imported i = import_tissue(scratch("arch.ply"), arch_options());
    EXPECT_EQ(i.report.bodies_kept, 1);
    EXPECT_THAT(i.report.repairs, testing::Contains(HasSubstr("1 small holes with 4 edges closed")));
    EXPECT_THAT(i.report.repairs, testing::Contains(HasSubstr("a base added")));
    EXPECT_THAT(i.report.repairs, testing::Contains("1 loose pieces left out"));
    EXPECT_THAT(i.report.notes, testing::Contains("gum and teeth are told by colour"));
    // The base lies 3 mm below the border's lowest point; the ragged border tilts it by less than two degrees.
    const double lowest = Arch::height(0, 0.97 * Arch::kHalf);
    EXPECT_NEAR(total(i) / Arch::volume(3 - lowest), 1, 0.08);
    EXPECT_NEAR(i.report.lo.z / kMillimetre, lowest - 3, 0.9);
    const auto below = [&](double angle, double across, double depth_mm) {
      return tissue_at(i.tissue, Arch::at(angle, across).p - dvec3(0, 0, depth_mm));
    };
    for (const double angle : {kPi / 6, kPi / 3}) {  // the middles of two crowns
      EXPECT_EQ(below(angle, 0, 0.5), Tissue::kEnamel);
      EXPECT_EQ(below(angle, 0, 2.5), Tissue::kDentin);
      EXPECT_EQ(below(angle, 6, 0.5), Tissue::kGingiva);
    }
    EXPECT_EQ(below(kPi / 4, 0, 0.5), Tissue::kGingiva) << "between two teeth";
  }
}

TEST(ImportArch, WithoutColoursTheGumIsFoundByHeightWithAMessage) {
  test::write(scratch("grey.ply"), Arch::ply(1, false, false));
  const Imported i = import_tissue(scratch("grey.ply"), arch_options());
  EXPECT_THAT(i.report.notes, testing::Contains(HasSubstr("no colours")));
  EXPECT_GT(volume(i, Tissue::kEnamel), 50);
  EXPECT_GT(volume(i, Tissue::kGingiva), 50);
}

/// A cast of a jaw: teeth along half a circle, and a flat floor 13 mm below their cusps inside the circle and around
/// it. Lengths are in mm.
struct Cast {
  static constexpr int kAcross = 140, kDeep = 90;
  static constexpr double kStep = 0.5, kRow = 24, kBase = 8;
  static double height(double x, double y) { return 13 * std::exp(-std::pow((std::hypot(x, y) - kRow) / 4.5, 4)); }
  /// Returns the cast as a PLY file. A closed cast has walls, and a flat base kBase below the floor.
  static std::string ply(bool closed, const glm::dmat3& turn = glm::dmat3(1)) {
    std::string points, faces;
    int count = 0;
    const auto face = [&](int a, int b, int c) { faces += fmt::format("3 {} {} {}\n", a, b, c), ++count; };
    const int below = (kAcross + 1) * (kDeep + 1);
    for (int layer = 0; layer <= (closed ? 1 : 0); ++layer) {
      for (int i = 0; i <= kAcross; ++i) {
        for (int j = 0; j <= kDeep; ++j) {
          const double x = kStep * (i - 0.5 * kAcross), y = kStep * j;
          const dvec3 p = turn * dvec3(x, y, layer == 0 ? height(x, y) : -kBase);
          points += fmt::format("{} {} {}\n", p.x, p.y, p.z);
          const int a = i * (kDeep + 1) + j + layer * below, b = a + kDeep + 1;
          if (i < kAcross && j < kDeep)
            layer == 0 ? (face(a, b, a + 1), face(a + 1, b, b + 1)) : (face(a, a + 1, b), face(a + 1, b + 1, b));
        }
      }
    }
    const auto wall = [&](int a, int b) { face(a, a + below, b), face(b, a + below, b + below); };
    for (int j = 0; j < kDeep && closed; ++j) {
      const int far = kAcross * (kDeep + 1);
      wall(j, j + 1), wall(far + j + 1, far + j);
    }
    for (int i = 0; i < kAcross && closed; ++i) {
      const int a = i * (kDeep + 1), b = a + kDeep + 1;
      wall(b, a), wall(a + kDeep, b + kDeep);
    }
    return ply_of((closed ? 2 : 1) * below, count, points + faces);
  }
};

TEST(ImportArch, TheTeethOfAClosedCastAreAwayFromItsFlatBaseWhicheverWayItLies) {
  ImportOptions o = arch_options();
  o.voxel = 0.4e-3;
  double upright = 0;
  const glm::dmat3 oblique(glm::rotate(glm::dmat4(1), 2.3, glm::normalize(dvec3(0.4, -0.7, 0.6))));
  for (const glm::dmat3& turn :
       {glm::dmat3(1), haptics::quarter_turns("x180"), haptics::quarter_turns("y90"), oblique}) {
    test::write(scratch("closed_cast.ply"), Cast::ply(true, turn));
    const Imported i = import_tissue(scratch("closed_cast.ply"), o);
    const double enamel = volume(i, Tissue::kEnamel);
    if (upright == 0) upright = enamel;
    EXPECT_GT(enamel, 500);
    // The rule that tells gum from teeth by height depends on the direction of its cells.
    EXPECT_NEAR(enamel / upright, 1, turn == oblique ? 0.3 : 0.05);
    EXPECT_EQ(tissue_at(i.tissue, turn * dvec3(0, 20, -Cast::kBase + 0.6)), Tissue::kGingiva);
    EXPECT_EQ(tissue_at(i.tissue, turn * dvec3(0, Cast::kRow, Cast::height(0, Cast::kRow) - 0.6)), Tissue::kEnamel);
  }
}

TEST(ImportArch, AClosedMeshWithoutABaseAndColoursIsRefused) {
  const auto file = ball({0, 0, 0}, 12).write("round.stl");
  EXPECT_THAT(message_of(file, arch_options()), HasSubstr("without a flat base"));
}

TEST(ImportArch, AFloorOfTheMouthFarFromAnyToothIsGum) {
  test::write(scratch("cast.ply"), Cast::ply(false));
  ImportOptions o = arch_options();
  o.voxel = 0.3e-3;
  const Imported i = import_tissue(scratch("cast.ply"), o);
  const auto below = [&](double x, double y) { return tissue_at(i.tissue, {x, y, Cast::height(x, y) - 0.5}); };
  for (const double x : {-6.0, 0.0, 5.0}) {
    for (const double y : {2.0, 6.0, 9.0}) EXPECT_EQ(below(x, y), Tissue::kGingiva) << x << " " << y;
  }
  for (const double angle : {0.3, 1.0, kPi / 2, 2.5})
    EXPECT_EQ(below(Cast::kRow * std::cos(angle), Cast::kRow * std::sin(angle)), Tissue::kEnamel) << angle;
}

TEST(ImportRepair, AMeshInMetresIsAskedForItsUnitAndNotGuessed) {
  EXPECT_THAT(message_of(ball({0, 0, 0}, 0.005).write("metres.stl"), bone()),
              HasSubstr("with --unit-mm 1000 it would be 10 mm long"));
  test::write(scratch("m.ply"), Arch::ply(1e-3, true, false));
  ImportOptions o = arch_options();
  EXPECT_THAT(message_of(scratch("m.ply"), o), HasSubstr("with --unit-mm 1000 it would be 2"));
  o.mesh_unit = 1;
  EXPECT_EQ(import_tissue(scratch("m.ply"), o).report.bodies_kept, 1);
}

TEST(ImportMemory, WorkThatDoesNotFitIsRefusedBeforeItBegins) {
  const auto file = ball({0, 0, 0}, 20).write("memory.stl");
  ImportOptions o = bone(0.2);
  o.memory = 50e6;
  double estimate = 0;
  o.estimated = [&](double bytes) { estimate = bytes; };
  EXPECT_THAT(message_of(file, o),
              AllOf(HasSubstr("--memory-mb"), HasSubstr("MB for this work"), HasSubstr("at most 50 MB")));
  EXPECT_EQ(estimate, 0);
  o.memory = 500e6;
  EXPECT_GT(import_tissue(file, o).report.memory, 50e6);
  EXPECT_GT(estimate, 50e6);
}

TEST(ImportMemory, ALimitOfTheAddressSpaceLeavesOnlyWhatTheProcessHasNotReserved) {
  const pid_t child = fork();
  if (child == 0) {
    double pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    constexpr double kLeft = 100e6;
    rlimit limit{};
    getrlimit(RLIMIT_AS, &limit);
    limit.rlim_cur = static_cast<rlim_t>(pages * static_cast<double>(sysconf(_SC_PAGESIZE)) + kLeft);
    if (setrlimit(RLIMIT_AS, &limit) != 0) _exit(2);
    const double free = importing::free_memory();
    _exit(free > 0.5 * kLeft && free <= 1.01 * kLeft ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

TEST(ImportMemory, AScanThatNeedsMoreThanTheLimitIsRefusedBeforeItsVoxelsAreRead) {
  test::Phantom p;
  p.size = {200, 200, 200};
  // Without its voxels, the file is refused because of its end, unless the memory is checked first.
  const auto file = test::write_nrrd("claims.nrrd", p, "");
  ImportOptions o = bone();
  o.memory = 50e6;
  EXPECT_THAT(message_of(file, o), AllOf(HasSubstr("64 MB as they are read"), HasSubstr("the limit of --memory-mb")));
  o.memory = 100e6;
  EXPECT_THAT(message_of(file, o), HasSubstr("expected 16000000 bytes"));
}

}  // namespace
}  // namespace typodont::haptics
