// Tests meshes as tissue: all formats give the same mesh, open and self-intersecting meshes become volumes, and bad
// meshes give an exact error.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <map>

#include "engine/base/units.h"
#include "haptics/import/mesh_tissue.h"
#include "haptics/tissue_volume.h"
#include "tests/support/dicom_files.h"
#include "tests/support/folder.h"
#include "tests/support/import_phantom.h"

namespace typodont::haptics {
namespace {

using test::scratch;
using testing::HasSubstr;

std::filesystem::path write(const std::string& name, const std::string& bytes) {
  const std::filesystem::path file = scratch(name);
  test::write(file, bytes);
  return file;
}

template <class T>
std::string raw(std::initializer_list<T> values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.begin(), bytes.size());
  return bytes;
}

/// A tetrahedron of 5 units in each of the formats.
constexpr double kCorner[4][3] = {{0, 0, 0}, {5, 0, 0}, {0, 5, 0}, {0, 0, 5}};
constexpr int kFace[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

std::string obj(bool turned = false) {
  std::string text;
  for (const auto& c : kCorner) text += fmt::format("v {} {} {}\n", c[0], c[1], c[2]);
  for (const auto& f : kFace)
    text += fmt::format("f {} {} {}\n", f[0] + 1, f[turned ? 2 : 1] + 1, f[turned ? 1 : 2] + 1);
  return text;
}
std::string ply() {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n"
      "property list uchar int vertex_indices\nend_header\n";
  for (const auto& c : kCorner) text += fmt::format("{} {} {}\n", c[0], c[1], c[2]);
  for (const auto& f : kFace) text += fmt::format("3 {} {} {}\n", f[0], f[1], f[2]);
  return text;
}
std::string stl() {
  std::string bytes(80, ' ');
  bytes += raw<std::uint32_t>({4});
  for (const auto& f : kFace) {
    bytes += raw<float>({0, 0, 0});
    for (const int i : f)
      for (const double x : kCorner[i]) bytes += raw<float>({static_cast<float>(x)});
    bytes += std::string(2, '\0');
  }
  return bytes;
}
std::string gltf() {
  std::string bytes;
  for (const auto& c : kCorner)
    for (const double x : c) bytes += raw<float>({static_cast<float>(x)});
  for (const auto& f : kFace)
    for (const int i : f) bytes += raw<std::uint16_t>({static_cast<std::uint16_t>(i)});
  write("tetra.bin", bytes);
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "buffers": [{"uri": "tetra.bin", "byteLength": 72}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [5, 5, 5]},
      {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]})";
}

/// An STL file as text, in upper case, with a byte order mark.
std::string text_stl() {
  std::string text = "\xef\xbb\xbfSOLID X\n";
  for (const auto& f : kFace) {
    text += "FACET NORMAL 0 0 0\nOUTER LOOP\n";
    for (const int i : f) text += fmt::format("VERTEX {} {} {}\n", kCorner[i][0], kCorner[i][1], kCorner[i][2]);
    text += "ENDLOOP\nENDFACET\n";
  }
  return text + "ENDSOLID X\n";
}
std::string strips() {
  std::string text = ply();
  text = text.substr(0, text.find("element face"));
  text += "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  for (const auto& c : kCorner) text += fmt::format("{} {} {}\n", c[0], c[1], c[2]);
  return text + "10 0 2 1 3 -1 1 3 0 2 -1\n";
}
std::string replaced(std::string text, const std::string& old, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(old, at)) != std::string::npos; at += by.size())
    text.replace(at, old.size(), by);
  return text;
}
std::string three_mf(const char* unit, double per_mm) {
  std::string model = fmt::format(
      "<?xml version=\"1.0\"?><model unit=\"{}\" xmlns=\"http://schemas.microsoft.com/"
      "3dmanufacturing/core/2015/02\"><resources><object id=\"1\" type=\"model\"><mesh>"
      "<vertices>",
      unit);
  for (const auto& c : kCorner)
    model += fmt::format("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", per_mm * c[0], per_mm * c[1], per_mm * c[2]);
  model += "</vertices><triangles>";
  for (const auto& f : kFace) model += fmt::format("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>", f[0], f[1], f[2]);
  model += "</triangles></mesh></object></resources><build><item objectid=\"1\"/></build></model>";
  return test::zip_bytes({{"_rels/.rels",
                           "<?xml version=\"1.0\"?><Relationships xmlns=\"http://schemas.openxmlformats.org/"
                           "package/2006/relationships\"><Relationship Target=\"/3D/3dmodel.model\" Id=\"r\" Type=\""
                           "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>"},
                          {"3D/3dmodel.model", model}});
}

double volume_of(const TissueMesh& mesh) {
  double six = 0;
  for (const glm::uvec3& t : mesh.triangles)
    six += glm::dot(mesh.vertices[t.x], glm::cross(mesh.vertices[t.y], mesh.vertices[t.z]));
  return six / 6;
}

TEST(TissueMesh, EveryFormatGivesTheSameMesh) {
  for (const auto& [name, bytes] :
       std::map<std::string, std::string>{{"tetra.obj", obj()},
                                          {"tetra.ply", ply()},
                                          {"tetra.stl", stl()},
                                          {"tetra.gltf", gltf()},
                                          {"text.stl", text_stl()},
                                          {"strips.ply", strips()},
                                          {"comments.obj", replaced(obj(), "\n", " # of the tooth\n")},
                                          {"encoded.gltf", replaced(gltf(), "tetra.bin", "%74etra.bin")},
                                          {"micron.3mf", three_mf("micron", 1000)},
                                          {"plain.3mf", three_mf("millimeter", 1)}}) {
    SCOPED_TRACE(name);
    const ReadTissueMesh read = read_tissue_mesh(write(name, bytes), 1e-3, Tissue::kDentin);
    EXPECT_EQ(read.mesh.vertices.size(), 4U);
    ASSERT_EQ(read.mesh.triangles.size(), 4U);
    EXPECT_EQ(read.mesh.tissue, std::vector<Tissue>(4, Tissue::kDentin));
    EXPECT_NEAR(volume_of(read.mesh) * 1e9, 125.0 / 6, 1e-9);
  }
}

TEST(TissueMesh, AnInsideOutMeshIsReversedWithAMessage) {
  const ReadTissueMesh read = read_tissue_mesh(write("turned.obj", obj(true)), 1e-3, Tissue::kEnamel);
  EXPECT_NEAR(volume_of(read.mesh) * 1e9, 125.0 / 6, 1e-9);
  ASSERT_EQ(read.repairs.size(), 1U);
  EXPECT_THAT(read.repairs[0], HasSubstr("turned"));
}

TEST(TissueMesh, BadTrianglesAreDroppedWithAMessage) {
  const ReadTissueMesh read =
      read_tissue_mesh(write("bad.obj", obj() + "f 1 1 2\nf 3 2 1\nf 1 3 2\n"), 1e-3, Tissue::kEnamel);
  // The face (1 3 2) is a second copy of a face. (3 2 1) is the same face in the opposite direction, so it stays.
  EXPECT_THAT(read.repairs,
              testing::ElementsAre(HasSubstr("1 triangles with two equal corners"), HasSubstr("2 second copies")));
}

TEST(TissueMesh, InvalidMeshesAreRefusedWithAReason) {
  const std::string open_ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n5 0 0\n";
  const struct {
    const char* name;
    std::string bytes;
    std::vector<const char*> message;
  } cases[] = {
      {"none.obj", "", {"an empty file"}},
      {"quantized.gltf",
       replaced(gltf(), "\"scene\": 0", "\"scene\": 0, \"extensionsRequired\": [\"KHR_mesh_quantization\"]"),
       {"extensionsRequired", "KHR_mesh_quantization"}},
      {"furlong.3mf", three_mf("furlong", 1), {"unit", "furlong", "inch"}},
      {"points.obj", "v 0 0 0\nv 1 0 0\n", {"points.obj"}},
      {"nan.ply", open_ply + "0 nan 0\n3 0 1 2\n", {"vertex 2"}},
      {"index.ply", open_ply + "0 5 0\n3 0 1 7\n", {"face 0", "a vertex that is not there"}},
      {"index.obj", "v 0 0 0\nv 5 0 0\nv 0 5 0\nf 1 2 9\n", {"index.obj"}},
      {"many.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
       "100000000\nproperty list uchar int vertex_indices\nend_header\n",
       {"line 7", "no more than the file can hold"}},
      {"tiny.obj", "v 0 0 0\nv 0.005 0 0\nv 0 0.005 0\nf 1 2 3\n", {"0.005 mm", "unit_mm"}},
      {"scan.nrrd", "NRRD0004\n", {".nrrd", "a mesh"}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    const std::string said = test::refusal([&] { read_tissue_mesh(write(c.name, c.bytes), 1e-3, Tissue::kEnamel); });
    for (const char* part : c.message) EXPECT_THAT(said, HasSubstr(part));
  }
}

/// Returns a ball that is divided along latitudes and longitudes, without the triangles above the height `cut` (in
/// radii).
TissueMesh ball(const dvec3& center, double radius, double cut = 2) {
  constexpr int kRings = 48, kSectors = 96;
  TissueMesh mesh;
  for (int i = 0; i <= kRings; ++i) {
    for (int j = 0; j < kSectors; ++j) {
      const double a = kPi * i / kRings, b = 2 * kPi * j / kSectors;
      mesh.vertices.push_back(center +
                              radius * dvec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
    }
  }
  const auto at = [](int i, int j) { return static_cast<unsigned>(i * kSectors + j % kSectors); };
  for (int i = 0; i < kRings; ++i) {
    if (std::cos(kPi * i / kRings) > cut) continue;
    for (int j = 0; j < kSectors; ++j) {
      if (i > 0) mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + 1 < kRings) mesh.triangles.emplace_back(at(i, j + 1), at(i + 1, j), at(i + 1, j + 1));
    }
  }
  mesh.tissue.assign(mesh.triangles.size(), Tissue::kDentin);
  return mesh;
}

double rasterized_volume(const TissueMesh& mesh, bool exact) {
  MeshTissueOptions options;
  options.tissue = Tissue::kDentin;
  options.voxel = 0.1e-3;
  const DenseTissue dense = rasterize(mesh, options);
  EXPECT_EQ(dense.exact_outside, exact);
  return TissueVolume(dense).volumes()[static_cast<std::size_t>(Tissue::kDentin)];
}

TEST(TissueMesh, ASceneMovesItsMesh) {
  const auto file = write("moved.obj", obj());
  const MeshTissueOptions options = read_mesh_tissue_options(
      Json::parse(R"({"file": "moved.obj", "unit_mm": 1, "move_mm": [1, -2, 3.5], "tissue": "enamel"})", "mesh"));
  const TissueMesh there = read_tissue_mesh(file, 1e-3, Tissue::kEnamel).mesh;
  const TissueMesh moved = read_tissue_mesh(file, options).mesh;
  ASSERT_EQ(moved.vertices.size(), there.vertices.size());
  for (std::size_t i = 0; i < there.vertices.size(); ++i) {
    EXPECT_LT(glm::distance(moved.vertices[i], there.vertices[i] + dvec3(1e-3, -2e-3, 3.5e-3)), 1e-12);
  }
  EXPECT_EQ(moved.triangles, there.triangles);
}

TEST(TissueMesh, OverlappingPartsAreOneBody) {
  TissueMesh both = ball({0, 0, 0}, 2e-3);
  const TissueMesh second = ball({2e-3, 0, 0}, 2e-3);
  const auto base = static_cast<unsigned>(both.vertices.size());
  both.vertices.insert(both.vertices.end(), second.vertices.begin(), second.vertices.end());
  for (const glm::uvec3& t : second.triangles) both.triangles.push_back(t + base);
  both.tissue.assign(both.triangles.size(), Tissue::kDentin);
  EXPECT_NEAR(rasterized_volume(second, true) / volume_of(second), 1, 2e-3);
  const double one = 4 * kPi / 3 * 8e-9,
               lens = kPi * 2.0 * 1e-3 * 1e-6 * (2 - 1.0 / 3);  // two caps of 1 mm: π h²(R − h/3)
  EXPECT_NEAR(rasterized_volume(both, true) / (2 * one - lens), 1, 5e-3);
}

TEST(TissueMesh, AnOpenMeshIsClosedByACap) {
  const TissueMesh mesh = ball({0, 0, 0}, 2e-3, 0.8);
  const double h = 0.2 * 2e-3, missing = kPi * h * h * (2e-3 - h / 3), whole = 4 * kPi / 3 * 8e-9;
  // The cap is where the winding number is one half, near the opening. So the volume is only known approximately.
  const double volume = rasterized_volume(mesh, false);
  EXPECT_LT(volume, whole);
  EXPECT_GT(volume, whole - 3 * missing);
}

TEST(TissueMesh, ASheetBecomesAShellTwoVoxelsThick) {
  TissueMesh sheet;
  sheet.vertices = {{0, 0, 0}, {5e-3, 0, 0}, {5e-3, 5e-3, 0}, {0, 5e-3, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  sheet.tissue.assign(2, Tissue::kDentin);
  EXPECT_NEAR(rasterized_volume(sheet, false) * 1e9, 5.1 * 5.1 * 0.2, 0.15);
}

}  // namespace
}  // namespace typodont::haptics
