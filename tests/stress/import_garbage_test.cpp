// Tests randomly damaged files: each is read, or refused with a message. Nothing else may happen.
#include <gtest/gtest.h>

#include <random>

#include "engine/base/error.h"
#include "haptics/import/import.h"
#include "tests/support/import_phantom.h"
#ifdef TYPODONT_DICOM
#include "tests/support/dicom_files.h"
#endif

namespace typodont::haptics {
namespace {

std::string damaged(const std::string& good, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  std::string b = good;
  const std::size_t head = std::min<std::size_t>(b.size(), 400);
  static const char* const kWords[] = {"-1",         "0", "1e308", "nan",  "inf",  "99999999999999999999",
                                       "2147483648", "",  "%s%n",  "LIST", "(1,2", "block",
                                       "65535"};
  switch (below(5)) {
    case 0:
      b.resize(below(b.size()));
      break;
    case 1:
      for (std::size_t k = 0; k <= below(5); ++k) b[below(head)] = static_cast<char>(below(256));
      break;
    case 2: {  // another word
      const std::size_t from = b.find(' ', below(head));
      if (from == std::string::npos) break;
      const std::size_t to = b.find_first_of(" \n", from + 1);
      b.replace(from + 1, to == std::string::npos ? 0 : to - from - 1, kWords[below(std::size(kWords))]);
      break;
    }
    case 3: {  // a line lost
      const std::size_t from = b.find('\n', below(head));
      if (from != std::string::npos) b.erase(from, b.find('\n', from + 1) - from);
      break;
    }
    default: {  // a number of another size
      const float value[] = {std::nanf(""), 1e38F, -1, 0};
      std::memcpy(&b[below(head - 4)], &value[below(4)], 4);
    }
  }
  return b;
}

TEST(ImportGarbage, DamagedFilesAreReadOrRefusedWithAMessage) {
  test::Phantom p;
  p.size = {14, 15, 16};
  p.spacing = dvec3(0.5);
  p.fine = 2;
  p.grey = [](const dvec3& q) { return glm::length(q - 3.7) < 2.4 ? 200.0 : 20.0; };
  const std::string data = test::bytes_as<std::uint8_t>(p.scan());
  std::string text;
  for (const char c : data) text += fmt::format("{} ", static_cast<int>(static_cast<unsigned char>(c)));
  std::string nifti(352, '\0');
  const auto put = [&](std::size_t at, auto value) { std::memcpy(&nifti[at], &value, sizeof value); };
  put(0, 348);
  for (std::size_t k = 0; k < 4; ++k) put(40 + 2 * k, static_cast<short>(std::array{3, 14, 15, 16}[k]));
  put(70, short{2});
  put(72, short{8});
  for (std::size_t k = 1; k < 4; ++k) put(76 + 4 * k, 0.5F);
  put(108, 352.0F);
  nifti[123] = 2;
  std::memcpy(&nifti[344], "n+1", 4);
  const std::vector<std::pair<std::string, std::string>> seeds = {
      {"s.nrrd", test::nrrd_header(p, "uchar", "encoding: raw\n") + data},
      {"t.nrrd", test::nrrd_header(p, "uchar", "encoding: ascii\n") + text},
      {"s.mha",
       "ObjectType = Image\nNDims = 3\nElementSpacing = 0.5 0.5 0.5\nOffset = 0 0 0\nDimSize = 14 15 16\nElementType = "
       "MET_UCHAR\nElementDataFile = LOCAL\n" +
           data},
      {"s.nii", nifti + data},
      {"s.ply",
       "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face "
       "4\nproperty list "
       "uchar int vertex_indices\nend_header\n0 0 0\n5 0 0\n0 5 0\n0 0 5\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"},
      {"s.obj", "v 0 0 0\nv 5 0 0\nv 0 5 0\nv 0 0 5\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"},
  };
  std::vector<std::pair<std::string, std::string>> all = seeds;
#ifdef TYPODONT_DICOM
  {
    test::DicomImage image;
    image.columns = 14, image.rows = 15, image.frames = 16;
    image.orientation = {{1, 0, 0}, {0, 1, 0}};
    image.spacing = {0.5, 0.5};
    for (const char c : data) image.pixels.push_back(static_cast<unsigned char>(c));
    for (int k = 0; k < 16; ++k) image.frame_positions.emplace_back(0, 0, 0.5 * k);
    all.emplace_back("s.dcm", test::dicom_bytes(image));
    all.emplace_back("s.zip", test::zip_bytes({{"a", test::dicom_bytes(image)}}));
  }
#endif
  ImportOptions options;
  options.voxel = 0.5e-3;
  std::mt19937 random(5);
  int refused = 0, read = 0;
  for (const auto& [name, good] : all) {
    test::write(test::scratch(name), good);
    EXPECT_NO_THROW(import_tissue(test::scratch(name), options)) << name;
    for (int k = 0; k < 60; ++k) {
      const std::string bad = damaged(good, random);
      test::write(test::scratch(name), bad);
      try {
        import_tissue(test::scratch(name), options);
        ++read;
      } catch (const Error& e) {
        ++refused;
        EXPECT_GT(std::string(e.what()).size(), 10U);
      }
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(read, 20);
}

}  // namespace
}  // namespace typodont::haptics
