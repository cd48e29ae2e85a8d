#include "haptics/import/scan_volume.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <optional>

#include "engine/base/error.h"
#include "engine/base/quantile.h"
#include "haptics/import/import_labels.h"
#include "haptics/import/import_scan.h"
#include "haptics/import/scan.h"

namespace typodont::haptics {

namespace {

constexpr std::size_t kPresets = 4;  // number of values of ImportPreset

importing::Scan read(const std::filesystem::path& file, const ImportOptions& options) {
  if (is_mesh_file(file))
    throw Error(file.string(), "", "a mesh", fmt::format("a scan ({}), or DICOM", fmt::join(scan_endings(), " ")));
  importing::Scan scan = importing::read_scan({file, options.series, options.memory}, options.spacing, options.nan_grey,
                                              {1e-6, 3e-3, "a bone", ""});
  importing::refuse_labels(file, scan);
  return scan;
}

}  // namespace

struct ScanVolume::Content {
  std::filesystem::path file;
  importing::Scan scan;
  std::optional<double> hounsfield;
  std::mutex mutex;  // protects `greys`
  std::array<std::optional<importing::ScanGreys>, kPresets> greys;
};

ScanVolume::ScanVolume(const std::filesystem::path& file, const ImportOptions& options)
    : content_(new Content{file, read(file, options), options.hounsfield, {}, {}}) {
  constexpr std::size_t kEnough = 1'000'000;
  constexpr double kDarkest = 0.02, kBrightest = 0.997;
  const std::vector<float>& greys = content_->scan.grey.v;
  std::vector<float> some;
  for (std::size_t i = 0; i < greys.size(); i += 1 + greys.size() / kEnough) some.push_back(greys[i]);
  black_ = lower_quantile(some, kDarkest);
  white_ = std::max(lower_quantile(some, kBrightest), black_ + 1e-6);
}

ScanVolume::~ScanVolume() = default;

dvec3 ScanVolume::lo() const {
  return content_->scan.origin;
}
dvec3 ScanVolume::hi() const {
  return lo() + dvec3(content_->scan.grey.size - 1) * spacing();
}
dvec3 ScanVolume::spacing() const {
  return content_->scan.spacing;
}
const std::string& ScanVolume::format() const {
  return content_->scan.format;
}
const std::string& ScanVolume::space() const {
  return content_->scan.space;
}
const std::vector<std::string>& ScanVolume::notes() const {
  return content_->scan.notes;
}

double ScanVolume::grey(const dvec3& p) const {
  return static_cast<double>(importing::sample(content_->scan.grey, (p - lo()) / spacing()));
}

Imported ScanVolume::import(const ImportOptions& given) const {
  ImportOptions options = given;
  options.hounsfield = content_->hounsfield;
  const auto greys = [&] {
    const std::lock_guard lock(content_->mutex);
    auto& of_preset = content_->greys.at(static_cast<std::size_t>(options.preset));
    if (!of_preset) of_preset = importing::find_greys(content_->file, content_->scan, options);
    return *of_preset;
  }();
  Imported imported = importing::import_region(content_->file, content_->scan, greys, options);
  return importing::completed(std::move(imported), options);
}

}  // namespace typodont::haptics
