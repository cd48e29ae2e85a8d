// Tests DICOM: every form of a series gives the same tissue at the same position, and no personal data appears in any
// output.
#include <gdcmImage.h>
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gmock/gmock.h>

#include <random>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/import/import.h"
#include "haptics/import/volume_export.h"
#include "tests/support/dicom_files.h"
#include "tests/support/import_message.h"

namespace typodont::haptics {
namespace {

using test::DicomImage;
using test::message_of;
using test::Placed;
using test::scratch;
using test::Syntax;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr double kVoxel = 0.25;                                                   // mm
const glm::ivec3 kSize(30, 26, 28);                                               // of the scan
const dvec3 kCenter(3.4, 3.1, 3.6), kLump(5.6, 3.1, 4.4), kOrigin(-20, 35, 112);  // mm

/// Returns the grey values of a ball like a tooth, with a lump towards the patient's left and slightly upwards.
std::vector<double> greys_of(const Placed& placed, const glm::ivec3& size, const dvec3& spacing) {
  test::Phantom p;
  p.size = size;
  p.spacing = spacing;
  p.fine = 4;
  p.grey = [&](const dvec3& q) {
    const dvec3 w = placed.origin + q.x * placed.x + q.y * placed.y + q.z * placed.z - kOrigin;
    const double r = glm::length(w - kCenter);
    if (glm::length(w - kLump) < 0.9) return 1220.0;
    return r < 0.7 ? 60.0 : r < 1.6 ? 830.0 : r < 2.4 ? 1220.0 : 400.0;
  };
  std::vector<double> greys = p.scan();
  for (double& g : greys) g = std::round(g);
  return greys;
}
const std::vector<double>& greys() {
  static const std::vector<double> g = greys_of({.origin = kOrigin}, kSize, dvec3(kVoxel));
  return g;
}
std::vector<DicomImage> slices() {
  return test::slices_of(greys(), kSize, dvec3(kVoxel), {.origin = kOrigin});
}
const Imported& reference() {
  static const Imported r = [] {
    const std::string header = fmt::format(
        "NRRD0004\ntype: ushort\ndimension: 3\nsizes: 30 26 28\nspace: left-posterior-superior\nspace directions: "
        "(0.25,0,0) (0,0.25,0) (0,0,0.25)\nspace origin: ({},{},{})\nendian: little\nencoding: raw\n\n",
        kOrigin.x, kOrigin.y, kOrigin.z);
    test::write(scratch("reference.nrrd"), header + test::bytes_as<std::uint16_t>(greys()));
    return import_tissue(scratch("reference.nrrd"), {});
  }();
  return r;
}
void expect_reference(const Imported& i) {
  EXPECT_EQ(i.report.format, "DICOM");
  EXPECT_EQ(i.report.space, "LPS");
  ASSERT_EQ(i.tissue.size, reference().tissue.size);
  EXPECT_EQ(i.tissue.distance, reference().tissue.distance);
  EXPECT_EQ(i.tissue.tissue, reference().tissue.tissue);
  EXPECT_LT(glm::length(i.tissue.frame.origin - reference().tissue.frame.origin), 1e-9);
}
Imported imported(const char* name, const std::vector<DicomImage>& images) {
  return import_tissue(test::write_series(name, images), {});
}
std::string refused(const char* name, const std::vector<DicomImage>& images) {
  return message_of(test::write_series(name, images));
}
std::string refused(const std::filesystem::path& file, const std::string& bytes) {
  test::write(file, bytes);
  return message_of(file);
}
/// Returns the file's bytes in another transfer syntax, converted by GDCM.
std::string compressed(const std::string& bytes, gdcm::TransferSyntax::TSType syntax) {
  const auto file = scratch("to_compress.dcm");
  test::write(file, bytes);
  gdcm::ImageReader reader;
  reader.SetFileName(file.c_str());
  EXPECT_TRUE(reader.Read());
  gdcm::ImageChangeTransferSyntax change;
  change.SetTransferSyntax(gdcm::TransferSyntax(syntax));
  change.SetInput(reader.GetImage());
  EXPECT_TRUE(change.Change());
  gdcm::ImageWriter writer;
  writer.SetFile(reader.GetFile());
  writer.SetImage(change.GetOutput());
  writer.SetFileName(file.c_str());
  EXPECT_TRUE(writer.Write());
  return test::read_text(file);
}

TEST(ImportDicom, EveryTransferSyntaxGivesTheSameTissue) {
  for (const Syntax syntax : {Syntax::kExplicit, Syntax::kImplicit, Syntax::kBigEndian, Syntax::kDeflated}) {
    SCOPED_TRACE(static_cast<int>(syntax));
    expect_reference(
        import_tissue(test::write_series(fmt::format("syntax{}", static_cast<int>(syntax)), slices(), syntax), {}));
  }
  using Ts = gdcm::TransferSyntax;
  for (const Ts::TSType syntax :
       {Ts::JPEGLosslessProcess14_1, Ts::JPEGLSLossless, Ts::JPEG2000Lossless, Ts::RLELossless}) {
    SCOPED_TRACE(Ts::GetTSString(syntax));
    const auto folder = scratch(fmt::format("codec{}", static_cast<int>(syntax)));
    std::filesystem::create_directories(folder);
    int k = 0;
    for (const DicomImage& image : slices())
      test::write(folder / fmt::format("{}", k++), compressed(test::dicom_bytes(image), syntax));
    expect_reference(import_tissue(folder, {}));
  }
}

TEST(ImportDicom, AFolderOfFoldersAnArchiveADirectoryFileAndOneFileGiveTheSameTissue) {
  const std::vector<DicomImage> images = slices();
  const auto folder = scratch("deep");
  std::filesystem::create_directories(folder / "A" / "B");
  std::vector<std::pair<std::string, std::string>> zipped;
  std::vector<std::string> records;
  for (std::size_t k = 0; k < images.size(); ++k) {
    const std::string bytes = test::dicom_bytes(images[k]), name = fmt::format("I{:03}", k);
    test::write(folder / "A" / "B" / name, bytes);
    zipped.emplace_back(fmt::format("../../{}/{}", test::kPatient, name), bytes);
    test::DicomWriter record(Syntax::kExplicit);
    record.text(0x0004, 0x1500, "CS", "A\\B\\" + name);
    records.push_back(record.bytes());
  }
  std::filesystem::create_directory_symlink(folder, folder / "A" / "loop");
  test::write(folder / "readme.txt", "no DICOM");
  expect_reference(import_tissue(folder, {}));
  test::write(scratch("scan.zip"), test::zip_bytes(zipped));
  expect_reference(import_tissue(scratch("scan.zip"), {}));
  test::DicomWriter directory(Syntax::kExplicit);
  directory.sequence(0x0004, 0x1220, records);
  test::write(folder / "DICOMDIR", directory.file());
  expect_reference(import_tissue(folder / "DICOMDIR", {}));
  expect_reference(import_tissue(folder, {}));  // with the DICOMDIR among them
  for (std::size_t k = 0; k < images.size(); ++k) {
    const auto file = folder / "A" / "B" / fmt::format("I{:03}", k);
    std::filesystem::rename(file, file.string() + ".dcm");
  }
  expect_reference(import_tissue(folder / "DICOMDIR", {}));

  DicomImage all = images[0];
  all.frames = kSize.z;
  all.position.reset();
  all.pixels.clear();
  for (const DicomImage& one : images) {
    all.pixels.insert(all.pixels.end(), one.pixels.begin(), one.pixels.end());
    all.frame_positions.push_back(*one.position);
  }
  test::write(scratch("frames.dcm"), test::dicom_bytes(all));
  expect_reference(import_tissue(scratch("frames.dcm"), {}));
}

TEST(ImportDicom, LeftStaysLeftHoweverTheSlicesLie) {
  const dvec3 right(1, 0, 0), back(0, 1, 0), up(0, 0, 1);
  const double reach = 7;  // mm, of the box
  const struct {
    const char* name;
    Placed placed;
  } cases[] = {
      {"axial from above", {right, back, -up, kOrigin + dvec3(0, 0, reach)}},
      {"axial face down", {-right, -back, up, kOrigin + dvec3(reach, reach, 0)}},
      {"coronal", {right, -up, back, kOrigin + dvec3(0, 0, reach)}},
      {"sagittal", {back, -up, -right, kOrigin + dvec3(reach, 0, reach)}},
      {"oblique",
       {glm::normalize(dvec3(0.9, 0.3, 0.2)),
        glm::normalize(glm::cross(glm::normalize(dvec3(-0.2, -0.1, 1)), glm::normalize(dvec3(0.9, 0.3, 0.2)))),
        dvec3(0), kOrigin + dvec3(0, -1.5, -1)}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    Placed placed = c.placed;
    glm::ivec3 size(32);
    if (placed.z == dvec3(0)) {
      size = glm::ivec3(48);
      placed.z = glm::cross(placed.x, placed.y);
      placed.origin = kOrigin + kCenter - 5.5 * (placed.x + placed.y + placed.z);
    }
    const std::vector<double> values = greys_of(placed, size, dvec3(kVoxel));
    const auto folder = test::write_series(c.name, test::slices_of(values, size, dvec3(kVoxel), placed));
    const Imported i = import_tissue(folder, {});
    const auto depth = [&](const dvec3& world_mm) {
      const dvec3 p = glm::transpose(i.report.world_rotation) * (world_mm * kMillimetre);
      const glm::ivec3 at(glm::round(i.tissue.frame.to_voxels(p)));
      return i.tissue.distance[i.tissue.at(at.x, at.y, at.z)] / kMillimetre;
    };
    EXPECT_NEAR(depth(kOrigin + kLump + dvec3(0.3, 0, 0)), -0.6, 0.2);                        // in the lump
    EXPECT_GT(depth(kOrigin + dvec3(2 * kCenter.x - kLump.x - 0.7, kLump.y, kLump.z)), 0.4);  // its mirror image
    EXPECT_LT(depth(kOrigin + kCenter), -1.2);
  }
}

TEST(ImportDicom, GantryTiltIsCorrected) {
  constexpr double kTilt = -18.5 * kPi / 180;
  // The slices lean back and are stacked along the table.
  Placed placed;
  placed.y = dvec3(0, std::cos(kTilt), std::sin(kTilt));
  placed.origin = kOrigin + dvec3(0, -1, -1);
  const dvec3 normal = glm::cross(placed.x, placed.y);
  const glm::ivec3 size(30, 40, 40);
  placed.z = dvec3(0, 0, 1) / std::cos(kTilt);  // so that slices lie a voxel apart along their normal
  std::vector<DicomImage> images = test::slices_of(greys_of(placed, size, dvec3(kVoxel)), size, dvec3(kVoxel), placed);
  for (DicomImage& image : images) image.tilt = -18.5;
  const Imported i = imported("tilted", images);
  EXPECT_THAT(i.report.notes, Contains(HasSubstr("18.5 degrees")));
  EXPECT_THAT(i.report.notes, Not(Contains(HasSubstr("positions count"))));
  EXPECT_NEAR(glm::length(glm::normalize(glm::dvec3(i.report.world_rotation[2])) - normal), 0, 1e-3);
  for (const dvec3& off :
       {dvec3(2.4, 0, 0), dvec3(0, 2.4, 0), dvec3(0, -2.4, 0), dvec3(0, 0, 2.4), dvec3(0, 0, -2.4)}) {
    if (off.x > 0) continue;  // the lump is there
    const dvec3 p = glm::transpose(i.report.world_rotation) * ((kOrigin + kCenter + off) * kMillimetre);
    const glm::ivec3 at(glm::round(i.tissue.frame.to_voxels(p)));
    const dvec3 back = i.report.world_rotation * i.tissue.frame.to_world(dvec3(at)) / kMillimetre - kOrigin;
    EXPECT_NEAR(i.tissue.distance[i.tissue.at(at.x, at.y, at.z)] / kMillimetre, glm::length(back - kCenter) - 2.4, 0.1);
  }
  for (DicomImage& image : images) image.tilt = 5;
  EXPECT_THAT(imported("tilted_wrongly", images).report.notes,
              Contains(AllOf(HasSubstr("5.0 degrees"), HasSubstr("positions count"))));
}

TEST(ImportDicom, RescaleOfEverySliceCounts) {
  std::vector<DicomImage> images = slices();
  for (std::size_t k = 0; k < images.size(); ++k) {
    images[k].slope = k % 2 ? 0.5 : 2;
    images[k].intercept = k % 3 ? -1000 : 7;
    for (std::uint16_t& g : images[k].pixels)
      g = static_cast<std::uint16_t>((2 * g - (k % 3 ? -2000 : 14)) / (2 * images[k].slope) * 1.0 +
                                     0.5 * (images[k].slope < 1));
  }
  const Imported i = imported("rescaled", images);
  // Half greys of slope 2 are rounded.
  EXPECT_NEAR(i.report.soft_grey, reference().report.soft_grey, 4);
  EXPECT_NEAR(i.report.height, reference().report.height, 0.01e-3);
}

TEST(ImportDicom, SeveralSeriesAreListedAndChosen) {
  std::vector<DicomImage> images = slices();
  for (std::size_t k = 0; k < images.size(); ++k) images[k].series_number = 3;
  const auto folder = test::write_series("several", images);
  DicomImage overview = images[0];
  overview.series = "1.2.3.9", overview.instance = "1.2.3.9.1", overview.image_type = "ORIGINAL\\PRIMARY\\LOCALIZER";
  test::write(folder / "overview", test::dicom_bytes(overview));
  const Imported one = import_tissue(folder, {});
  expect_reference(one);
  EXPECT_THAT(one.report.notes, Contains("1 overview pictures beside the series were left out"));
  for (std::size_t k = 0; k < 10; ++k) {
    DicomImage other = images[k];
    other.series = "1.2.3.8", other.instance = fmt::format("1.2.3.8.{}", k), other.series_number = 8;
    test::write(folder / fmt::format("other{}", k), test::dicom_bytes(other));
  }
  EXPECT_THAT(message_of(folder), AllOf(HasSubstr("2 series"), HasSubstr("1: CT, series 3, 28 slices of 30 x 26"),
                                        HasSubstr("2: CT, series 8, 10 slices"), HasSubstr("--series N")));
  ImportOptions options;
  options.series = 1;
  expect_reference(import_tissue(folder, options));
  options.series = 3;
  EXPECT_THAT(message_of(folder, options), AllOf(HasSubstr("--series"), HasSubstr("found 3")));
}

TEST(ImportDicom, CopiesOfSlicesAreLeftOutAndASecondAcquisitionIsAnotherScan) {
  std::vector<DicomImage> images = slices();
  images.push_back(images[4]);
  const Imported one = imported("copies", images);
  expect_reference(one);
  EXPECT_THAT(one.report.notes, Contains("1 second copies of slices were left out"));
  images.back().instance = "1.2.3.4.99";
  EXPECT_THAT(refused("phases", images),
              AllOf(HasSubstr("slices 5 and 6"), HasSubstr("0 mm apart"), HasSubstr("one phase")));
  images.pop_back();
  const std::size_t count = images.size();
  for (std::size_t k = 0; k < count; ++k) {
    images.push_back(images[k]);
    images.back().acquisition = 2, images.back().instance += ".2";
  }
  ImportOptions options;
  options.series = 2;
  expect_reference(import_tissue(test::write_series("acquisitions", images), options));
}

TEST(ImportDicom, UnevenSlicesAreInterpolatedAndMissingOnesRefused) {
  // Every slice is slightly displaced from its regular position.
  std::vector<DicomImage> images;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> off(-0.04, 0.04);
  for (int k = 0; k < kSize.z; ++k) {
    Placed placed{.origin = kOrigin + dvec3(0, 0, kVoxel * k + (k == 0 || k == kSize.z - 1 ? 0 : off(random)))};
    DicomImage image = test::slices_of(greys_of(placed, {kSize.x, kSize.y, 1}, dvec3(kVoxel)), {kSize.x, kSize.y, 1},
                                       dvec3(kVoxel), placed)[0];
    image.instance = fmt::format("1.2.3.4.{}", k);
    images.push_back(image);
  }
  const Imported i = imported("uneven", images);
  EXPECT_THAT(i.report.notes, Contains(AllOf(HasSubstr("uneven slices"), HasSubstr("interpolated to 28"))));
  EXPECT_LT(glm::length(i.report.lo - reference().report.lo), 0.03e-3);
  EXPECT_LT(glm::length(i.report.hi - reference().report.hi), 0.03e-3);
  std::vector<DicomImage> fewer = slices();
  fewer.erase(fewer.begin() + 11, fewer.begin() + 13);
  EXPECT_THAT(refused("missing", fewer), AllOf(HasSubstr("slices 11 and 12 of 26"), HasSubstr("0.75 mm apart"),
                                               HasSubstr("2 slices are missing")));
}

TEST(ImportDicom, SlicesWithoutPositionsAreUsedInTheirOrderWithAMessage) {
  std::vector<DicomImage> images = slices();
  for (DicomImage& image : images) image.position.reset(), image.orientation.reset(), image.gap = kVoxel;
  const Imported i = imported("unplaced", images);
  EXPECT_EQ(i.tissue.distance, reference().tissue.distance);
  EXPECT_EQ(i.report.space, "");
  EXPECT_THAT(i.report.notes, Contains(HasSubstr("do not say where they lie")));
  for (DicomImage& image : images) image.gap = 0;
  EXPECT_THAT(refused("unspaced", images), AllOf(HasSubstr("no voxel spacing"), HasSubstr("--spacing-mm")));
}

TEST(ImportDicom, SlicesWithoutUsefulPositionsArePlacedByTheirLocationWithAMessage) {
  std::vector<DicomImage> images = slices();
  for (std::size_t k = 0; k < images.size(); ++k) {
    images[k].location = kVoxel * static_cast<double>(k);
    images[k].order = static_cast<int>(5 * k % images.size());  // orders, names and thicknesses say something else
    images[k].thickness = 2 * kVoxel;
    images[k].position.reset();
  }
  const Imported unplaced = imported("located", images);
  EXPECT_EQ(unplaced.tissue.distance, reference().tissue.distance);
  EXPECT_THAT(unplaced.report.notes, Contains(HasSubstr("no Image Position, so the slices are placed by Slice Loc")));
  for (DicomImage& image : images) image.position = kOrigin;
  const Imported same = imported("same_place", images);
  EXPECT_EQ(same.tissue.distance, reference().tissue.distance);
  EXPECT_THAT(same.report.notes, Contains(HasSubstr("same Image Position, so the slices are placed by Slice Loc")));
  for (DicomImage& image : images) image.position.reset(), image.location.reset();
  EXPECT_THAT(imported("thick", images).report.notes,
              Contains(HasSubstr("no distance between slices: it is taken to be their thickness")));
  for (DicomImage& image : images) image.order = 1;
  EXPECT_THAT(refused("no_order", images), HasSubstr("without an order, a position or a loc"));
}

TEST(ImportDicom, TwoReconstructionsInOneSeriesAreTwoScans) {
  std::vector<DicomImage> images = slices();
  const std::size_t count = images.size();
  for (std::size_t k = 0; k < count; ++k) {
    images[k].kernel = "SOFT";
    images.push_back(images[k]);
    images.back().kernel = "SHARP", images.back().instance += ".2";
    for (std::uint16_t& g : images.back().pixels) g = 400;
  }
  const auto folder = test::write_series("kernels", images);
  EXPECT_THAT(message_of(folder), AllOf(HasSubstr("1: CT, series 1, kernel SHARP, 28 slices"), HasSubstr("2: CT, seri"),
                                        HasSubstr("kernel SOFT")));
  ImportOptions options;
  options.series = 2;
  expect_reference(import_tissue(folder, options));
}

TEST(ImportDicom, PaddingIsReadAsAir) {
  std::vector<DicomImage> images = slices();
  for (DicomImage& image : images) {
    image.padding = 63000;
    for (int x = 0; x < kSize.x; ++x) image.pixels[static_cast<std::size_t>(x)] = 63000;
  }
  const Imported i = imported("padded", images);
  EXPECT_NEAR(i.report.soft_grey, reference().report.soft_grey, 4);
  EXPECT_NEAR(i.report.height, reference().report.height, 0.02e-3);
  EXPECT_THAT(i.report.notes, Contains(HasSubstr("4 % of the voxels lie outside the measured region")));
}

TEST(ImportDicom, UnusedLowBitsAreShiftedOutAndContradictionsRefused) {
  std::vector<DicomImage> images = slices();
  for (DicomImage& image : images) {
    image.bits_stored = 12;
    for (std::uint16_t& g : image.pixels) g = static_cast<std::uint16_t>(g << 4 | 5);
  }
  expect_reference(imported("high_bit", images));
  for (DicomImage& image : images) image.high_bit = 7;
  EXPECT_THAT(refused("low_high_bit", images), HasSubstr("High Bit (0028,0102) that contradict"));
}

TEST(ImportDicom, ANumberThatIsCutAtAnUnknownCharacterIsRefused) {
  std::vector<DicomImage> images = slices();
  for (const char* text : {"1,5", "1.5x", "1 5", "1\\x"}) {
    SCOPED_TRACE(text);
    images[9].slope_text = text;
    EXPECT_THAT(message_of(test::write_series(fmt::format("number{}", text[1]), images)),
                AllOf(HasSubstr("Rescale Slope (0028,1053)"), HasSubstr(fmt::format("found \"{}\"", text))));
  }
}

TEST(ImportDicom, NoPersonalDataAreWritten) {
  std::vector<DicomImage> images = slices();
  const Imported i = imported("person", images);
  std::vector<std::string> said = i.report.notes;
  said.insert(said.end(), {i.report.format, i.report.space});
  // Error messages must not contain personal data either, although they are about single files.
  std::vector<DicomImage> missing = images;
  missing.erase(missing.begin() + 5);
  said.push_back(refused("person_missing", missing));
  std::vector<DicomImage> two = images;
  for (std::size_t k = 0; k < 14; ++k) two[k].series = "1.2.7";
  said.push_back(refused("person_two", two));
  const auto damaged = test::write_series("person_damaged", images);
  for (const auto& file : std::filesystem::directory_iterator(damaged))
    std::filesystem::resize_file(file.path(), std::filesystem::file_size(file.path()) - 300);
  said.push_back(message_of(damaged));
  for (const std::string& text : said) {
    EXPECT_NE(text, "");
    for (const char* secret : {"HUSH", "HANNAH", "078-05", "19010203", "1901"})
      EXPECT_THAT(text, Not(HasSubstr(secret)));
  }
}

/// Returns the value of an element as text without padding.
std::string text_of(const gdcm::DataSet& set, std::uint16_t group, std::uint16_t element) {
  const gdcm::ByteValue* value = set.GetDataElement(gdcm::Tag(group, element)).GetByteValue();
  std::string text = value ? std::string(value->GetPointer(), value->GetLength()) : "";
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}
const gdcm::DataSet& first_item(const gdcm::DataSet& set, std::uint16_t group, std::uint16_t element) {
  return set.GetDataElement(gdcm::Tag(group, element)).GetValueAsSQ()->GetItem(1).GetNestedDataSet();
}

TEST(ImportDicom, ASegmentationHasTheLabelsAtTheirPositionsAndNoPersonalData) {
  // The slices are oblique and in another order, and the result is rotated.
  const double a = 25 * kPi / 180;
  const Placed placed{.x = {std::cos(a), std::sin(a), 0},
                      .y = {-std::sin(a), std::cos(a), 0},
                      .z = {0, 0, 1},
                      .origin = kOrigin + dvec3(1.6, -1.1, 0)};
  const auto folder = test::write_series(
      "to_label", test::slices_of(greys_of(placed, kSize, dvec3(kVoxel)), kSize, dvec3(kVoxel), placed));
  ImportOptions options;
  options.turn = quarter_turns("x90,z-90");
  const Imported i = import_tissue(folder, options);
  const auto file = folder / "labels.dcm";
  write_labels(i.tissue, file);

  gdcm::Reader reader;
  reader.SetFileName(file.c_str());
  ASSERT_TRUE(reader.Read());
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  EXPECT_EQ(text_of(set, 0x0008, 0x0016), "1.2.840.10008.5.1.4.1.1.66.4");
  for (const auto element : std::initializer_list<std::uint16_t>{0x0010, 0x0020, 0x0030, 0x0040})
    EXPECT_EQ(text_of(set, 0x0010, element), "");
  const auto segments = set.GetDataElement(gdcm::Tag(0x0062, 0x0002)).GetValueAsSQ();
  std::vector<std::string> names;
  for (std::size_t k = 1; k <= segments->GetNumberOfItems(); ++k)
    names.push_back(text_of(segments->GetItem(k).GetNestedDataSet(), 0x0062, 0x0005));
  EXPECT_THAT(names, testing::ElementsAre("dentin", "pulp"));
  const auto numbers = [](const std::string& text) {
    std::vector<double> values;
    for (std::size_t at = 0; at <= text.size(); at = std::min(text.find('\\', at), text.size()) + 1)
      values.push_back(std::stod(text.substr(at)));
    return values;
  };
  const gdcm::DataSet& shared = first_item(set, 0x5200, 0x9229);
  const auto along = numbers(text_of(first_item(shared, 0x0020, 0x9116), 0x0020, 0x0037));
  const gdcm::DataSet& measures = first_item(shared, 0x0028, 0x9110);
  EXPECT_EQ(numbers(text_of(measures, 0x0028, 0x0030)), (std::vector<double>{kVoxel, kVoxel}));
  const auto frames = set.GetDataElement(gdcm::Tag(0x5200, 0x9230)).GetValueAsSQ();
  const gdcm::ByteValue* bits = set.GetDataElement(gdcm::Tag(0x7fe0, 0x0010)).GetByteValue();
  ASSERT_EQ(std::to_string(frames->GetNumberOfItems()), text_of(set, 0x0028, 0x0008));
  const glm::ivec3 size = i.tissue.size;
  const std::size_t slice = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  ASSERT_EQ(bits->GetLength(), ((frames->GetNumberOfItems() * slice + 7) / 8 + 1) / 2 * 2);
  // Adds the position (mm, LPS) of every labelled voxel of each tissue, in the file and in the result of the import.
  std::vector<std::array<double, 4>> stored(names.size()), expected(names.size());
  for (std::size_t f = 0; f < frames->GetNumberOfItems(); ++f) {
    const gdcm::DataSet& item = frames->GetItem(f + 1).GetNestedDataSet();
    const auto at = numbers(text_of(first_item(item, 0x0020, 0x9113), 0x0020, 0x0032));
    std::uint16_t segment = 0;
    std::memcpy(&segment,
                first_item(item, 0x0062, 0x000a).GetDataElement(gdcm::Tag(0x0062, 0x000b)).GetByteValue()->GetPointer(),
                2);
    for (std::size_t k = 0; k < slice; ++k) {
      const std::size_t bit = f * slice + k;
      if (!(bits->GetPointer()[bit / 8] >> bit % 8 & 1)) continue;
      const auto x = static_cast<double>(k % static_cast<std::size_t>(size.x)),
                 y = static_cast<double>(k / static_cast<std::size_t>(size.x));
      auto& sum = stored[segment - 1u];
      for (std::size_t c = 0; c < 3; ++c) sum[c] += at[c] + kVoxel * (x * along[c] + y * along[c + 3]);
      sum[3] += 1;
    }
  }
  for_each_voxel(size, [&](int x, int y, int z) {
    const std::size_t k = i.tissue.at(x, y, z);
    if (i.tissue.distance[k] > 0) return;
    const dvec3 p = i.report.world_rotation * i.tissue.frame.to_world(dvec3(x, y, z)) / kMillimetre;
    const std::string name(name_of(i.tissue.tissue[k]));
    auto& sum = expected[static_cast<std::size_t>(std::ranges::find(names, name) - names.begin())];
    for (int c = 0; c < 3; ++c) sum[static_cast<std::size_t>(c)] += p[c];
    sum[3] += 1;
  });
  for (std::size_t s = 0; s < names.size(); ++s) {
    SCOPED_TRACE(names[s]);
    EXPECT_EQ(stored[s][3], expected[s][3]);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(stored[s][c] / stored[s][3], expected[s][c] / expected[s][3], 1e-6);
  }
  const std::string bytes = test::read_text(file);
  for (const char* personal : {test::kPatient, test::kPatientId, test::kBirthDate, "1.2.3.4"})
    EXPECT_EQ(bytes.find(personal), std::string::npos) << personal;
  // The segmentation is now beside the slices. It is no scan, so the folder is imported as before.
  EXPECT_EQ(import_tissue(folder, options).tissue.distance, i.tissue.distance);
  EXPECT_THAT(message_of(file), HasSubstr("found"));
}

TEST(ImportDicom, DamagedAndOversizedInputIsRefusedWithAReasonAndLittleMemory) {
  std::vector<DicomImage> images = slices();
  // The pixel data is cut off.
  const auto cut = test::write_series("cut", images);
  const auto victim = std::filesystem::directory_iterator(cut)->path();
  std::filesystem::resize_file(victim, std::filesystem::file_size(victim) / 2);
  EXPECT_NE(message_of(cut), "");
  // A claim of 100 GB in a small file.
  DicomImage boast = images[0];
  boast.rows = boast.columns = 65535, boast.frames = 4000;
  boast.position.reset();
  EXPECT_THAT(refused(scratch("boast.dcm"), test::dicom_bytes(boast)),
              AllOf(HasSubstr("65535 x 65535 x 4000"), HasSubstr("at most")));
  boast.frames = 1;
  boast.rows = boast.columns = 20000;
  for (int k = 0; k < 4; ++k) {
    boast.instance = fmt::format("1.9.{}", k), boast.position = dvec3(0, 0, k);
    std::filesystem::create_directories(scratch("boasts"));
    test::write(scratch("boasts") / fmt::format("{}", k), test::dicom_bytes(boast));
  }
  EXPECT_THAT(message_of(scratch("boasts")), HasSubstr("at most"));
  // The folder is empty or has one slice.
  std::filesystem::create_directories(scratch("empty_folder"));
  EXPECT_THAT(message_of(scratch("empty_folder")), HasSubstr("no DICOM images"));
  EXPECT_THAT(refused(scratch("single.dcm"), test::dicom_bytes(images[0])),
              AllOf(HasSubstr("at most 1 slices"), HasSubstr("its folder")));
  // Archives.
  const std::string good = test::zip_bytes({{"a", test::dicom_bytes(images[0])}, {"b", test::dicom_bytes(images[1])}});
  EXPECT_THAT(refused(scratch("cut.zip"), good.substr(0, good.size() - 60)), HasSubstr("ZIP archive"));
  std::string lies = good;
  const std::size_t entry = lies.find("PK\1\2");
  lies[entry + 27] = '\x7f';  // two gigabytes unpacked
  EXPECT_THAT(refused(scratch("bomb.zip"), lies), AllOf(HasSubstr("file 1"), HasSubstr("deflate")));
  std::string secret = good;
  secret[entry + 8] = 1;
  EXPECT_THAT(refused(scratch("secret.zip"), secret), HasSubstr("encrypted"));
  // A name that is not UTF-8.
  const auto odd = scratch("odd\xff\xfe");
  std::filesystem::create_directories(odd);
  for (std::size_t k = 0; k < images.size(); ++k)
    test::write(odd / fmt::format("\xe9{}", k), test::dicom_bytes(images[k]));
  expect_reference(import_tissue(odd, {}));
}

}  // namespace
}  // namespace typodont::haptics
