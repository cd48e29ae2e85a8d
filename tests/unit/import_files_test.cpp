// Tests scans as files: every format and encoding gives the same tissue, and every broken file gives an exact message.
#include <gmock/gmock.h>

#include <cstring>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/import.h"
#include "haptics/import/volume_export.h"
#include "haptics/tissue_volume.h"
#include "tests/support/deflated.h"
#include "tests/support/import_message.h"
#include "tests/support/import_phantom.h"

namespace typodont::haptics {
namespace {

using test::bytes_as;
using test::deflated;
using test::message_of;
using test::scratch;
using test::write;
using test::write_nrrd;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// A small ball like a tooth. It is not in the middle in any axis, so that exchanged or mirrored axes are noticed.
test::Phantom small_ball() {
  test::Phantom p;
  p.size = {30, 26, 28};
  p.spacing = dvec3(0.25);
  p.blur = 0.2;
  p.fine = 4;
  p.grey = [](const dvec3& q) {
    const double r = glm::length(q - dvec3(3.4, 3.1, 3.6));
    return r < 0.7 ? 10.0 : r < 1.6 ? 130.0 : r < 2.4 ? 220.0 : 60.0;
  };
  return p;
}
const std::vector<double>& greys() {
  static const std::vector<double> g = [] {
    std::vector<double> v = small_ball().scan();
    for (double& x : v) x = std::round(x);
    return v;
  }();
  return g;
}
const Imported& reference() {
  static const Imported r =
      import_tissue(write_nrrd("reference.nrrd", small_ball(), bytes_as<std::uint16_t>(greys())), {});
  return r;
}
void expect_reference(const Imported& i) {
  ASSERT_EQ(i.tissue.size, reference().tissue.size);
  EXPECT_EQ(i.tissue.distance, reference().tissue.distance);
  EXPECT_EQ(i.tissue.tissue, reference().tissue.tissue);
  EXPECT_LT(glm::length(i.tissue.frame.origin - reference().tissue.frame.origin), 1e-9);
}
void expect_same(const std::string& name, const std::string& bytes) {
  SCOPED_TRACE(name);
  write(scratch(name), bytes);
  expect_reference(import_tissue(scratch(name), {}));
}
const std::string& shorts() {
  static const std::string s = bytes_as<std::uint16_t>(greys());
  return s;
}
const std::string kLittle = "endian: little\nencoding: raw\n", kBig = "endian: big\nencoding: raw\n";
std::string nrrd(const std::string& type, const std::string& more, const std::string& data) {
  return test::nrrd_header(small_ball(), type, more) + data;
}
/// Returns an NRRD file with these lines about its place.
std::string placed_nrrd(const std::string& lines, const std::string& data = shorts()) {
  return "NRRD0004\ntype: ushort\ndimension: 3\nsizes: 30 26 28\n" + lines + kLittle + "\n" + data;
}
/// Returns an NRRD file of a scan that is rotated by `r` in the given space. `origin`: mm
std::string oblique_nrrd(const char* space, const glm::dmat3& r, const dvec3& origin) {
  std::string directions;
  for (int k = 0; k < 3; ++k) directions += fmt::format(" ({},{},{})", 0.25 * r[k].x, 0.25 * r[k].y, 0.25 * r[k].z);
  return placed_nrrd(fmt::format("space: {}\nspace directions:{}\nspace origin: ({},{},{})\n", space, directions,
                                 origin.x, origin.y, origin.z));
}
std::string metaimage(const std::string& more, const std::string& data,
                      const std::string& size = "NDims = 3\nElementSpacing = 0.25 0.25 0.25\nDimSize = 30 26 28\n",
                      const char* file = "LOCAL") {
  return fmt::format("ObjectType = Image\nBinaryData = True\n{}{}ElementDataFile = {}\n{}", size, more, file, data);
}
std::string nifti(short datatype, short bits, const std::string& data, float spacing = 0.25F, char units = 2) {
  std::string h(352, '\0');
  const auto put = [&](std::size_t at, auto value) { std::memcpy(&h[at], &value, sizeof value); };
  put(0, 348);
  const short dim[8] = {3, 30, 26, 28, 1, 1, 1, 1};
  for (std::size_t k = 0; k < 8; ++k) put(40 + 2 * k, dim[k]);
  put(70, datatype);
  put(72, bits);
  for (std::size_t k = 0; k < 4; ++k) put(76 + 4 * k, k ? spacing : 1.0F);
  put(108, 352.0F);
  h[123] = units;
  std::memcpy(&h[344], "n+1", 4);
  return h + data;
}

TEST(ImportNrrd, EveryTypeEncodingByteOrderUnitAndSpaceGivesTheSameTissue) {
  const std::string swapped = bytes_as<std::uint16_t>(greys(), true);
  expect_same("big.nrrd", nrrd("uint16", kBig, swapped));
  expect_same("u8.nrrd", nrrd("uchar", "encoding: raw\n", bytes_as<std::uint8_t>(greys())));
  expect_same("i16.nrrd", nrrd("short", kLittle, bytes_as<std::int16_t>(greys())));
  expect_same("i32.nrrd", nrrd("int", kBig, bytes_as<std::int32_t>(greys(), true)));
  expect_same("u32.nrrd", nrrd("uint", kLittle, bytes_as<std::uint32_t>(greys())));
  expect_same("f.nrrd", nrrd("float", kBig, bytes_as<float>(greys(), true)));
  expect_same("d.nrrd", nrrd("double", kLittle, bytes_as<double>(greys())));
  expect_same("gz.nrrd", nrrd("ushort", "endian: little\nencoding: gzip\n", deflated(shorts(), 31)));
  std::string text;
  for (const double g : greys()) text += fmt::format("{} ", g);
  expect_same("text.nrrd", nrrd("ushort", "encoding: ascii\n", text));
  write(scratch("detached.raw"), swapped);
  expect_same("detached.nhdr", nrrd("ushort", kBig + "data file: ./detached.raw", ""));
  test::Phantom um = small_ball();
  um.spacing = dvec3(250);
  expect_same("um.nrrd", test::nrrd_header(um, "ushort", "units: \"um\" \"um\" \"um\"\n" + kLittle) + shorts());
  expect_same("space.nrrd", placed_nrrd("space: left-posterior-superior\nspacings: 0.25 0.25 0.25\n"));
}

TEST(ImportMetaImage, UnitsEncodingsFurtherAxesLongCommentsAndForeignPathsAreRead) {
  expect_same("a.mha", metaimage("BinaryDataByteOrderMSB = True\nElementType = MET_USHORT\n",
                                 bytes_as<std::uint16_t>(greys(), true)));
  expect_same("z.mha",
              metaimage("CompressedData = True\nElementType = MET_FLOAT\n", deflated(bytes_as<float>(greys()), 15)));
  const std::string type = "ElementType = MET_USHORT\n", four = "NDims = 4\nElementSpacing = 0.25 0.25 0.25 1\n";
  expect_same("cm.mha", metaimage(type, shorts(),
                                  "NDims = 3\nDistanceUnits = cm\nElementSpacing = 0.025 0.025 0.025\n"
                                  "DimSize = 30 26 28\n"));
  expect_same("four.mha", metaimage(type + "Comment = " + std::string(5000, 'x') +
                                        "\nTransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n",
                                    shorts(), four + "DimSize = 30 26 28 1\n"));
  write(scratch("away.raw"), shorts());
  expect_same("away.mhd", metaimage(type, "", "NDims = 3\nElementSpacing = 0.25 0.25 0.25\nDimSize = 30 26 28\n",
                                    "C:\\Scans\\away.raw"));
  write(scratch("series.mha"), metaimage(type, shorts() + shorts(), four + "DimSize = 30 26 28 2\n"));
  EXPECT_THAT(message_of(scratch("series.mha")), AllOf(HasSubstr("DimSize"), HasSubstr("3 axes longer than one")));
}

TEST(ImportNifti, PlainAndGzippedGiveTheSameTissue) {
  expect_same("a.nii", nifti(512, 16, shorts()));
  expect_same("a.nii.gz", deflated(nifti(16, 32, bytes_as<float>(greys())), 31));
}

TEST(ImportSpacing, OverridesScaleTheBody) {
  ImportOptions options;
  options.spacing = dvec3(0.5e-3);
  const Imported twice = import_tissue(write_nrrd("twice.nrrd", small_ball(), shorts()), options);
  EXPECT_NEAR(twice.report.height, 2 * reference().report.height, 1e-6);
}

TEST(ImportSpacing, MissingOrAbsurdSpacingAsksForTheTrueOne) {
  const auto said = [](const char* name, const std::string& lines) {
    write(scratch(name), placed_nrrd(lines));
    return message_of(scratch(name));
  };
  EXPECT_THAT(said("none.nrrd", ""),
              AllOf(HasSubstr("none.nrrd"), HasSubstr("no voxel spacing"), HasSubstr("--spacing-mm X,Y,Z")));
  EXPECT_THAT(said("ones.nrrd", "spacings: 1 1 1\n"),
              AllOf(HasSubstr("line 5 (spacings)"), HasSubstr("1 1 1 without a unit"), HasSubstr("--spacing-mm")));
  EXPECT_THAT(said("huge.nrrd", "spacings: 4 4 4\n"), AllOf(HasSubstr("4 4 4 mm"), HasSubstr("--spacing-mm")));
  EXPECT_THAT(said("unit.nrrd", "spacings: 1 1 1\nunits: \"s\" \"s\" \"s\"\n"), HasSubstr("a unit of length"));
  write(scratch("ones.nii"), nifti(512, 16, shorts(), 1, 0));
  EXPECT_THAT(message_of(scratch("ones.nii")), AllOf(HasSubstr("pixdim"), HasSubstr("--spacing-mm")));
}

TEST(ImportSpacing, AFileThatSaysItsVoxelAndUnitIsNotAskedForThem) {
  test::Phantom p = small_ball();
  p.spacing = dvec3(0.9);
  const auto file = write_nrrd("coarse.nrrd", p, shorts(), "ushort", "units: \"mm\" \"mm\" \"mm\"\n" + kLittle);
  EXPECT_THAT(message_of(file), AllOf(HasSubstr("0.9 0.9 0.9 mm"), HasSubstr("fine enough for a tooth"),
                                      HasSubstr("--preset bone"), Not(HasSubstr("true voxel"))));
  // The length of the body is checked, too: a tooth may have at most 60 mm.
  p.spacing = dvec3(0.65);
  p.size = {150, 26, 28};
  p.grey = [](const dvec3& q) {
    return std::abs(q.y - 8) < 4 && std::abs(q.z - 9) < 4 && q.x > 5 && q.x < 90 ? 200.0 : 9.0;
  };
  p.fine = 1;
  EXPECT_THAT(message_of(write_nrrd("long.nrrd", p, bytes_as<std::uint16_t>(p.scan()))),
              AllOf(HasSubstr("a body 8"), HasSubstr("--preset bone"), Not(HasSubstr("true voxel"))));
}

TEST(ImportFiles, NanVoxelsGetTheGivenGreyValue) {
  std::vector<double> with_nan = greys();
  with_nan[0] = with_nan[77] = std::nan("");
  const auto file = write_nrrd("nans.nrrd", small_ball(), bytes_as<float>(with_nan), "float");
  ImportOptions options;
  options.nan_grey = 60;
  const Imported i = import_tissue(file, options);
  expect_reference(i);
  EXPECT_THAT(i.report.notes, testing::Contains(HasSubstr("2 of 21840 voxels were no number")));
}

TEST(ImportOrientation, AnObliqueScanKeepsItsPlaceInTheWorld) {
  // The same ball with its axes rotated by 25 degrees about z and then by 10 degrees about x.
  const double a = 25 * kPi / 180, b = 10 * kPi / 180;
  const glm::dmat3 rz(dvec3(std::cos(a), std::sin(a), 0), dvec3(-std::sin(a), std::cos(a), 0), dvec3(0, 0, 1));
  const glm::dmat3 rx(dvec3(1, 0, 0), dvec3(0, std::cos(b), std::sin(b)), dvec3(0, -std::sin(b), std::cos(b)));
  const glm::dmat3 r = rx * rz;
  const dvec3 origin(12, -7, 30);
  write(scratch("oblique.nrrd"), oblique_nrrd("left-posterior-superior", r, origin));
  const Imported i = import_tissue(scratch("oblique.nrrd"), {});
  EXPECT_EQ(i.report.space, "LPS");
  ASSERT_EQ(i.tissue.size, reference().tissue.size);
  EXPECT_EQ(i.tissue.distance, reference().tissue.distance);
  // The middle of the volume in frame W.
  const dvec3 middle = reference().tissue.frame.to_world(dvec3(10, 11, 12)) / kMillimetre;
  const dvec3 world = i.report.world_rotation * i.tissue.frame.to_world(dvec3(10, 11, 12)) / kMillimetre;
  EXPECT_LT(glm::length(world - (origin + r * middle)), 1e-6);
}

/// A ball of enamel of radius 4 mm with dentin of radius 3 mm, as labels 7 and 9; voxels of 0.25 mm.
std::string ball_of_labels() {
  std::string voxels;
  for_each_voxel(glm::ivec3(40), [&](int z, int y, int x) {
    const double r = 0.25 * glm::length(dvec3(x, y, z) - 19.6);
    voxels += static_cast<char>(r < 3 ? 9 : r < 4 ? 7 : 0);
  });
  return voxels;
}
std::string label_nrrd(const std::string& lines) {
  return "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 40 40 40\nspace: left-posterior-superior\nspace directions: "
         "(0.25,0,0) (0,0.25,0) (0,0,0.25)\nencoding: raw\n" +
         lines + "\n" + ball_of_labels();
}

TEST(ImportLabels, ALabelMapIsReadAsLabelsWithASmoothSurface) {
  write(scratch("ball.nrrd"), label_nrrd("Segment0_LabelValue:=7\nSegment0_Name:=Enamel\nSegment0_Layer:=0\n"
                                         "Segment1_LabelValue:=9\nSegment1_Name:=Dentin\nSegment1_Layer:=0\n"));
  const Imported ball = import_tissue(scratch("ball.nrrd"), {});
  const double all = 4 * kPi / 3 * 64e-9, dentin = 4 * kPi / 3 * 27e-9;
  EXPECT_NEAR(total(ball.report.volume) / all, 1, 0.02);
  EXPECT_NEAR(ball.report.volume[static_cast<std::size_t>(Tissue::kDentin)] / dentin, 1, 0.02);
  double worst = 0;
  const DenseTissue& t = ball.tissue;
  for_each_voxel(t.size, [&](int x, int y, int z) {
    const double r = glm::length(t.frame.to_world(dvec3(x, y, z)) - 0.25e-3 * 19.6), d = t.distance[t.at(x, y, z)];
    if (std::abs(d) < 0.5e-3) worst = std::max(worst, std::abs(d - (r - 4e-3)));
  });
  EXPECT_LT(worst, 0.1e-3) << "stairs would be off by half a voxel, 0.125 mm";
}

TEST(ImportLabels, ValuesWithoutATissueAreAskedForAndLabelsAreNeverTakenForGreys) {
  write(scratch("nameless.nrrd"), label_nrrd(""));
  EXPECT_THAT(message_of(scratch("nameless.nrrd")), AllOf(HasSubstr("a label map"), HasSubstr("--label VALUE=TISSUE")));
  write(scratch("foreign.nrrd"), label_nrrd("Segment0_LabelValue:=7\nSegment0_Name:=Crown\nSegment1_LabelValue:=9\n"
                                            "Segment1_Name:=Dentin\n"));
  EXPECT_THAT(message_of(scratch("foreign.nrrd")),
              AllOf(HasSubstr("7 (\"Crown\")"), HasSubstr("--label 7=TISSUE"), HasSubstr("dentin")));
  ImportOptions named;
  named.labels = {{7, Tissue::kAir}, {9, Tissue::kDentin}};
  EXPECT_NEAR(total(import_tissue(scratch("nameless.nrrd"), named).report.volume) / (4 * kPi / 3 * 27e-9), 1, 0.02);
  named.labels[3] = Tissue::kPulp;
  EXPECT_THAT(message_of(scratch("nameless.nrrd"), named), HasSubstr("one of the values 0, 7, 9"));
  std::vector<float> voxels(512, 0.0F);
  voxels[100] = 1e20F;
  write(
      scratch("huge_label.nrrd"),
      "NRRD0004\ntype: float\ndimension: 3\nsizes: 8 8 8\nspace: left-posterior-superior\nspace directions: (0.25,0,0) "
      "(0,0.25,0) (0,0,0.25)\nendian: little\nencoding: raw\n\n" +
          std::string(reinterpret_cast<const char*>(voxels.data()), voxels.size() * sizeof(float)));
  EXPECT_THAT(message_of(scratch("huge_label.nrrd"), named), HasSubstr("the value 1e+20, expected whole numbers"));
  write(scratch("layers.nrrd"), label_nrrd("Segment0_LabelValue:=7\nSegment0_Name:=Enamel\nSegment0_Layer:=1\n"));
  EXPECT_THAT(message_of(scratch("layers.nrrd")), HasSubstr("one layer"));
}

TEST(ImportLabels, AVolumeFileKeepsThePlaceInTheScanAndDistancesAreWrittenThere) {
  // An oblique scan in RAS coordinates. The result is turned and moved, and stored as a volume file.
  const double a = 25 * kPi / 180;
  const glm::dmat3 r(dvec3(std::cos(a), std::sin(a), 0), dvec3(-std::sin(a), std::cos(a), 0), dvec3(0, 0, 1));
  const dvec3 origin(12, -7, 30);
  write(scratch("oblique.nrrd"), oblique_nrrd("right-anterior-superior", r, origin));
  ImportOptions options;
  options.turn = quarter_turns("x90,z-90");
  Imported i = import_tissue(scratch("oblique.nrrd"), options);
  const dvec3 move(0.003, -0.002, 0.001);
  i.tissue.frame.origin += move;
  i.tissue.place.X_FW = i.tissue.place.X_FW * Pose{-move, {1, 0, 0, 0}};
  TissueVolume(i.tissue).save(scratch("oblique.vdb"));
  const TissueVolume volume = TissueVolume::load(scratch("oblique.vdb"));
  EXPECT_EQ(volume.place().axes, PatientAxes::kRas);
  EXPECT_EQ(volume.clone().place().axes, PatientAxes::kRas);
  // The middle of the ball, mm, in the scan and in the volume.
  const dvec3 ball = origin + r * dvec3(3.4, 3.1, 3.6);
  dvec3 sum(0);
  double count = 0;
  for_each_voxel(i.tissue.size, [&](int x, int y, int z) {
    if (i.tissue.distance[i.tissue.at(x, y, z)] > 0) return;
    sum += i.tissue.frame.to_world(dvec3(x, y, z)), count += 1;
  });
  EXPECT_LT(glm::length(volume.place().X_FW * (sum / count) / kMillimetre - ball), 0.05);
  DenseTissue dense = i.tissue;
  dense.place = volume.place();
  for (const char* name : {"distances.nrrd", "distances.nii"}) {
    SCOPED_TRACE(name);
    write_distances(dense, scratch(name));
    const std::string bytes = test::read_text(scratch(name));
    if (std::string(name).ends_with(".nii")) {
      // Position of voxel (0, 0, 0) in RAS, from the rows of the matrix in the header.
      dvec3 first;
      for (int row = 0; row < 3; ++row) {
        float value = 0;
        std::memcpy(&value, &bytes[280 + 16 * static_cast<std::size_t>(row) + 12], sizeof value);
        first[row] = static_cast<double>(value);
      }
      EXPECT_LT(glm::length(first - volume.place().X_FW * dense.frame.origin / kMillimetre), 1e-4);
      float d = 0;
      std::memcpy(&d, &bytes[352], sizeof d);
      EXPECT_NEAR(static_cast<double>(d), static_cast<double>(dense.distance[0]) / kMillimetre, 1e-6);
      ASSERT_EQ(bytes.size(), 352 + 4 * dense.distance.size());
    } else {
      EXPECT_THAT(bytes, AllOf(HasSubstr("type: float"), HasSubstr("left-posterior-superior"), HasSubstr("in mm")));
    }
  }
  EXPECT_THROW(write_distances(dense, scratch("distances.dcm")), Error);
  EXPECT_FALSE(std::filesystem::exists(scratch("distances.dcm")));
}

TEST(ImportErrors, NameFilePlaceFoundAndExpected) {
  const std::string& data = shorts();
  struct Case {
    const char* name;
    std::string bytes;
    std::vector<const char*> said;
  };
  std::vector<double> with_nan = greys();
  with_nan[30 * 26 * 5 + 30 * 4 + 3] = std::nan("");
  std::string fewer;
  for (int k = 0; k < 21839; ++k) fewer += "7\n";
  const std::vector<Case> cases = {
      {"truncated.nrrd", nrrd("ushort", kLittle, data.substr(0, 20000)), {"truncated.nrrd", "20", "43680 bytes"}},
      {"type.nrrd",
       nrrd("unsigned snort", kLittle, data),
       {"line 2 (type)", "unsigned snort", "expected a scalar type"}},
      {"sizes.nrrd",
       "NRRD0004\ntype: ushort\ndimension: 3\nsizes: 90000 90000 90000\nspacings: 1 1 1\n" + kLittle + "\n" + data,
       {"line 4 (sizes)", "90000 x 90000 x 90000", "at most"}},
      {"flat.nrrd",
       "NRRD0004\ntype: ushort\ndimension: 2\nsizes: 780 28\n" + kLittle + "\n" + data,
       {"sizes", "2 axes", "a scan of 3 axes"}},
      {"nan.nrrd",
       nrrd("float", kLittle, bytes_as<float>(with_nan)),
       {"voxel (3, 4, 5)", "nan", "as in 1 of 21840 voxels", "a finite grey value", "--nan-as GREY"}},
      {"garbage.nrrd", "What is this?\n" + data, {"line 1", "What is this?", "NRRD0001"}},
      {"absent.nhdr", nrrd("ushort", kLittle + "data file: not_there.raw", ""), {"data file", "not_there.raw"}},
      {"packed.nrrd",
       nrrd("ushort", "endian: little\nencoding: gzip\n", deflated(data, 31).substr(0, 3000)),
       {"packed.nrrd: data", "43680 bytes of voxels (30 x 26 x 28), encoded as gzip"}},
      {"few.nrrd",
       nrrd("ushort", "encoding: ascii\n", std::string(50000, '7')),
       {"few.nrrd: data", "a number of more than 100 digits"}},
      {"fewer.nrrd", nrrd("ushort", "encoding: ascii\n", fewer + "\n"), {"fewer.nrrd: data", "43680 bytes of voxels"}},
      {"flat_grey.nrrd", nrrd("ushort", kLittle, std::string(data.size(), '\1')), {"the same value", "tissue"}},
      {"type.mha",
       metaimage("ElementType = MET_QUATERNION\n", data),
       {"line 6 (ElementType)", "MET_QUATERNION", "a scalar type"}},
      {"short.mha", metaimage("ElementType = MET_USHORT\n", data.substr(0, 999)), {"999 bytes", "43680"}},
      {"bad.mha", metaimage("CompressedData = True\nElementType = MET_USHORT\n", data), {"compressed data"}},
      {"dims.mha",
       "NDims = 300\nDimSize = 1 2 3\nElementType = MET_CHAR\nElementDataFile = LOCAL\n",
       {"line 1 (NDims)", "300", "expected 3"}},
      {"none.nii", data, {"none.nii", "NIfTI"}},
      {"short.nii", nifti(512, 16, data.substr(0, 100)), {"short.nii", "bytes"}},
      {"complex.nii", nifti(32, 64, data + data + data + data), {"datatype", "COMPLEX64", "a scalar number"}},
      {"empty.nrrd", "", {"empty.nrrd", "an empty file"}},
      {"picture.png", "\x89PNG....", {"picture.png", "NRRD"}},
      {"open.obj",
       "v 0 0 0\nv 9 0 0\nv 12 8 0\nv 5 14 0\nv -3 8 0\nv 4 5 9\nf 1 2 6\nf 2 3 6\nf 3 4 6\nf 4 5 6\nf 5 1 6\n",
       {"5 open edges", "a closed surface"}},
      {"count.ply",
       "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n",
       {"line 3", "4000000000"}},
      {"count.stl", std::string(80, 'x') + std::string("\xff\xff\xff\x7f", 4), {"byte 80", "50 bytes for each"}},
  };
  for (const Case& c : cases) {
    write(scratch(c.name), c.bytes);
    const std::string said = message_of(scratch(c.name));
    EXPECT_NE(said, "") << c.name;
    for (const char* part : c.said) EXPECT_THAT(said, HasSubstr(part)) << c.name;
  }
  EXPECT_THAT(message_of(scratch("nowhere.nrrd")), HasSubstr("No such file"));
  ImportOptions options;
  options.voxel = 0.005e-3;
  EXPECT_THAT(message_of(write_nrrd("fine.nrrd", small_ball(), data), options),
              AllOf(HasSubstr("--voxel-mm"), HasSubstr("at most")));
}

}  // namespace
}  // namespace typodont::haptics
