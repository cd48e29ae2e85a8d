#include "engine/app/operator/scan_desk.h"

#include <utility>

#include "engine/app/operator/scene_works.h"
#include "engine/base/log.h"
#include "engine/gpu/device.h"

namespace typodont {

namespace {
constexpr int kScanPixels = 384;  // pixels, side of a section's picture

struct DrawnSections {
  ScanPlanes planes;
  std::vector<render::Picture> pictures;
};

haptics::Imported labels_of(const haptics::ScanVolume& scan, const LabelRequest& request, Progress& progress) {
  haptics::ImportOptions options = request.options;
  options.progress = [&](double done) { progress.at(done); };
  return scan.import(options);
}

void take_labels(ScanForm& form, const LabelRequest& request, haptics::Imported labels) {
  form.change([request, labels = std::move(labels)](ScanReview& review) mutable {
    review.take(request, std::move(labels));
    log::info("labels computed: {}", request.detail == LabelDetail::kFull ? "full" : "coarse");
  });
}
}  // namespace

void ScanDesk::open() {
  close();
  s_.open(Page::kScan);
  if (s_.import.name[0] == 0) propose_name(s_);
  work_.make(
      [tooth = tooth_of(s_.import)](Progress& progress) {
        progress.stage("op.loading", 0, 1);
        const auto scan = std::make_shared<const haptics::ScanVolume>(tooth.input, tooth.options);
        auto loaded = std::make_shared<ScanReview>(scan);
        progress.at(1);
        return loaded;
      },
      [this](std::shared_ptr<ScanReview> loaded) {
        s_.scan.review = std::move(loaded);
        s_.import.preset = static_cast<int>(s_.scan.review->preset());
        s_.say(s_.text("op.scan_help"));
        const haptics::ScanVolume& scan = *s_.scan.review->scan();
        const dvec3 size = (scan.hi() - scan.lo()) / scan.spacing();
        log::info("scan read: {}, {:.0f} x {:.0f} x {:.0f} voxels", scan.format(), size.x + 1, size.y + 1, size.z + 1);
      },
      [this](const std::exception&) {
        s_.page = Page::kArchive;
        throw;
      });
}

void ScanDesk::begin_coarse(const LabelRequest& request) {
  coarse_.make(
      [request, scan = s_.scan.review->scan()](Progress& progress) { return labels_of(*scan, request, progress); },
      [this, request](haptics::Imported labels) { take_labels(s_.scan, request, std::move(labels)); },
      [this, request](const std::exception& e) {
        s_.scan.change([request](ScanReview& review) { review.give_up(request); });
        s_.fail(e.what());
      });
}

void ScanDesk::begin_full(const LabelRequest& request) {
  full_ = request.revision;
  s_.say("");
  work_.make(
      [request, scan = s_.scan.review->scan()](Progress& progress) {
        progress.stage("op.scan_labelling", 0, 1);
        return labels_of(*scan, request, progress);
      },
      [this, request](haptics::Imported labels) {
        full_.reset();
        take_labels(s_.scan, request, std::move(labels));
      },
      [this, request](const std::exception&) {
        full_.reset();
        s_.scan.change([request](ScanReview& review) { review.give_up(request); });
        throw;
      });
}

bool ScanDesk::look() {
  ScanForm& form = s_.scan;
  if (s_.page != Page::kScan || !form.review) return false;
  const bool drawn = preview_.look(), labelled = coarse_.look(), finished = drawn || labelled;
  if (preview_.under_way()) return finished;
  ScanReview& review = *form.review;
  for (const auto& change : std::exchange(form.changes, {})) {
    try {
      change(review);
    } catch (const gpu::DeviceLost&) {
      throw;
    } catch (const std::exception& e) {
      s_.fail(e.what());
    }
  }
  if (const std::optional<LabelRequest> wanted = review.request()) {
    if (full_ && wanted->revision != *full_) work_.cancel();
    if (wanted->detail == LabelDetail::kCoarse && !coarse_.under_way()) begin_coarse(*wanted);
    if (wanted->detail == LabelDetail::kFull && !coarse_.under_way() && !work_.under_way()) begin_full(*wanted);
  }
  if (!preview_.due(drawn_ != review.changes())) return finished;
  drawn_ = review.changes();
  preview_.begin(
      [review = form.review](Progress& progress) {
        DrawnSections sections{review->planes(), {}};
        for (const SectionPlane& plane : sections.planes) {
          progress.at(0);
          sections.pictures.push_back(review->picture(plane, kScanPixels));
        }
        return sections;
      },
      [&form](const DrawnSections& sections) {
        form.planes = sections.planes;
        return true;
      });
  return finished;
}

void ScanDesk::import(Choices& choices) {
  if (std::exchange(import_asked_, true)) return;
  s_.scan.change([this, &choices](const ScanReview& review) {
    import_asked_ = false;
    import_reviewed(s_, work_, choices, review);
  });
}

void ScanDesk::close() {
  preview_.close();
  coarse_.drop();
  full_.reset();
  import_asked_ = false;
  s_.scan = {};
}

}  // namespace typodont
