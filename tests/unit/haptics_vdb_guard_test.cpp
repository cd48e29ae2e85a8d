// Volume files that were damaged, wherever that is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "engine/base/error.h"
#include "engine/base/json.h"
#include "haptics/solid.h"
#include "haptics/tissue_volume.h"
#include "tests/support/program.h"

namespace typodont::haptics {
namespace {

using test::read_text;
using testing::HasSubstr;

class VdbGuard : public testing::Test {
 protected:
  VdbGuard() {
    TissueVolume(
        read_solids(Json::parse(
            R"({"voxel_mm": 0.5, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]})", "x")))
        .save(file_);
    bytes_ = read_text(file_);
  }
  ~VdbGuard() override { std::filesystem::remove(file_); }
  void write(const std::string& bytes) const {
    std::filesystem::remove(file_);
    std::ofstream(file_, std::ios::binary) << bytes;
  }
  std::string message() const {
    try {
      (void)TissueVolume::load(file_);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }
  static constexpr std::size_t kSealBytes = 16;
  const std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("typodont_guard_" + std::to_string(getpid()) + ".vdb");
  std::string bytes_;
};

TEST_F(VdbGuard, AnyChangedByteOfASealedFileIsNoticed) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    std::string damaged = bytes_;
    char& byte = damaged[random() % (damaged.size() - kSealBytes)];
    byte = static_cast<char>(byte ^ static_cast<char>(1 + random() % 255));
    write(damaged);
    EXPECT_THAT(message(), HasSubstr("changed since it was written"));
  }
}

TEST_F(VdbGuard, AFileFromElsewhereWithoutASealIsReadAsItIs) {
  write(bytes_);
  const std::uint64_t sealed = TissueVolume::load(file_).hash();
  write(bytes_.substr(0, bytes_.size() - kSealBytes));
  EXPECT_EQ(TissueVolume::load(file_).hash(), sealed);
}

TEST_F(VdbGuard, AnUnsealedFileCutOffAnywhereIsRefused) {
  for (std::size_t size = 0; size < bytes_.size() - kSealBytes; size += 97) {
    write(bytes_.substr(0, size));
    EXPECT_NE(message(), "") << size;
  }
}

TEST_F(VdbGuard, ALengthBeyondTheFileIsNamed) {
  std::string damaged = bytes_.substr(0, bytes_.size() - kSealBytes);
  const std::size_t name =
      damaged.find("Tree_float");  // the type of the first grid, its length in the four bytes before
  ASSERT_NE(name, std::string::npos);
  damaged[name - 1] = '\x7f';
  write(damaged);
  EXPECT_THAT(message(), HasSubstr("type of a grid"));
}

}  // namespace
}  // namespace typodont::haptics
