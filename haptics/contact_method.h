// Contact methods by the names that a scene's "model" and --model use.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"
#include "haptics/contact/contact_model.h"
#include "haptics/contact/tissue_body.h"
#include "haptics/tool.h"

namespace typodont::haptics {

struct ServoSettings;

/// With its parameters. Immutable; shared by servo and carver thread. make functions throw Error.
class ContactMethod {
 public:
  virtual ~ContactMethod() = default;
  virtual std::string_view name() const = 0;
  /// Its bodies have triangles of their own, which are drawn (TissueBody::surface).
  virtual bool draws_own_surface() const { return false; }
  /// For the servo thread. `settings`, complete with frame, must outlive the model.
  virtual std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const = 0;
  /// For the carver thread. `tools`: the session's, indexed by Cut::tool.
  virtual std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const = 0;
};
using SharedContactMethod = std::shared_ptr<const ContactMethod>;

/// Reads parameters from the scene; nullopt: only the name is there. Throws Error.
using ContactMethodReader = std::function<SharedContactMethod(const std::optional<Json>& parameters)>;

/// Registers a contact method that another module defines. Declare an object at namespace scope in any file of the
/// program:
///   const ContactMethodRegistration registration{"mine", [](const auto& parameters) { … }};
/// Throws std::logic_error if the name already exists.
struct ContactMethodRegistration {
  ContactMethodRegistration(std::string name, ContactMethodReader reader);
};

/// With default parameters. Throws Error with all names; `where`: file or option.
SharedContactMethod contact_method(std::string_view name, std::string_view where);
/// "offset", or {"offset": {parameters}}. Throws Error.
SharedContactMethod read_contact_method(const Json& json);
/// As shown to users. ("god-object" is an alias of "offset".)
std::vector<std::string> contact_method_names();
/// "one of: offset, …".
std::string known_contact_methods();

/// Models (servo thread) and bodies (carver thread) created by this process.
struct MethodCount {
  std::string name;
  std::uint64_t models = 0, bodies = 0;
};
/// In the order of contact_method_names(). Thread-safe.
std::vector<MethodCount> method_counts();

/// Returns the method that is used if none is chosen: "offset".
const SharedContactMethod& default_contact_method();

}  // namespace typodont::haptics
