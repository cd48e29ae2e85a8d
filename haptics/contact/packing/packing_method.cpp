#include "haptics/contact/packing/packing_method.h"

#include <algorithm>
#include <utility>

#include "engine/base/units.h"
#include "haptics/contact/packing/packing_body.h"
#include "haptics/contact/packing/packing_model.h"
#include "haptics/packing_loader.h"
#include "haptics/sphere_packer.h"

namespace typodont::haptics {

namespace {

PackingLoader& loader() {
  static PackingLoader load;
  return load;
}

}  // namespace

PackingLoaderRegistration::PackingLoaderRegistration(PackingLoader load) {
  loader() = std::move(load);
}

namespace packing {

namespace {

class PackingMethod final : public ContactMethod {
 public:
  explicit PackingMethod(Parameters parameters, std::optional<SpherePacking> packing)
      : parameters_(std::move(parameters)), packing_(std::move(packing)) {
    if (packing_) parameters_.spheres = packing_->size();
  }
  std::string_view name() const override { return kName; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    return std::make_unique<PackingModel>(settings, parameters_);
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const override {
    if (packing_) return std::make_unique<PackingBody>(std::move(tissue), *packing_, tools, parameters_);
    PackOptions options;
    options.spheres = parameters_.spheres;
    options.seed = parameters_.seed;
    const SpherePacking packing = pack_spheres(tissue, options);
    return std::make_unique<PackingBody>(std::move(tissue), packing, tools, parameters_);
  }

 private:
  Parameters parameters_;
  std::optional<SpherePacking> packing_;  // from a file
};

}  // namespace

SharedContactMethod read(const std::optional<Json>& json) {
  Parameters p;
  std::optional<SpherePacking> packing;
  if (json) {
    json->allow_only(
        {"spheres", "seed", "file", "tool_spheres", "speed_mm_per_s", "density", "density_by_contact", "as_printed"});
    constexpr auto kMost = static_cast<long long>(PackOptions::kMaxSpheres);
    if (const auto n = json->find("spheres")) p.spheres = static_cast<std::size_t>(n->integer(1, kMost));
    if (const auto n = json->find("seed")) p.seed = static_cast<std::uint64_t>(n->integer(0));
    if (const auto n = json->find("tool_spheres")) p.tool_spheres = static_cast<std::size_t>(n->integer(1, 2000));
    if (const auto speed = json->find("speed_mm_per_s")) p.base_speed = speed->number(1e-3, 1e3) * kMillimetre;
    if (const auto by_contact = json->find("density_by_contact")) {
      if (!(p.base_speed > 0)) by_contact->fail("density_by_contact without speed_mm_per_s", "both");
      p.by_contact = by_contact->boolean();
    }
    p.removal = json->boolean_or("as_printed", false) ? Removal::kAsPrinted : Removal::kMended;
    if (const auto densities = json->find("density")) {
      for (const std::string& name : densities->keys()) {
        const auto tissue = tissue_named(name);
        if (!tissue || *tissue == Tissue::kAir) densities->fail('"' + name + '"', "names of tissues");
        p.density[static_cast<std::size_t>(*tissue)] = (*densities)[name].number(0, 1000);
      }
    }
    if (const auto file = json->find("file")) {
      if (json->has("spheres")) json->fail("spheres and file", "one of both");
      if (!loader()) file->fail("a program that cannot read packings", "a program that can");
      p.file = json->file().parent_path() / file->string();
      packing = loader()(p.file);
    }
  }
  return std::make_shared<PackingMethod>(std::move(p), std::move(packing));
}

}  // namespace packing

}  // namespace typodont::haptics
