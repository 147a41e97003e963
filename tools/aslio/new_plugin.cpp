/// `aslio new-plugin`: a project for a stage outside the repository, from the templates that are installed.

#include <fmt/format.h>
#include <stdlib.h>  // mkdtemp

#include <algorithm>
#include <cctype>
#include <fstream>
#include <memory>
#include <sstream>
#include <vector>

#include "aslio/core/errors.hpp"
#include "command.hpp"
#include "console.hpp"
#include "data_folder.hpp"
#include "options.hpp"
#include "stages.hpp"

namespace aslio::cli {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestName = 40;

struct NewPluginArguments {
  std::string stage, directory;
};

/// What stands for the names in a template.
struct Names {
  std::string family;  ///< for @family@
  std::string type;    ///< for my_stage
  /// For MyStage. No type of aslio or of a template ends in Stage: a stage that is called `params` or `window_plan` is
  /// neither the struct inside it nor what it includes.
  std::string class_name() const {
    constexpr std::string_view kEnd = "Stage";
    std::string name;
    bool begins = true;
    for (const char c : type) {
      if (c != '_') name += begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
      begins = c == '_';
    }
    if (!name.ends_with(kEnd) || name == kEnd) name += kEnd;
    return name;
  }
};

bool is_name(std::string_view text) {
  const auto allowed = [](char c) { return c == '_' || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  return !text.empty() && text.size() <= kLongestName && text.front() >= 'a' && text.front() <= 'z' &&
         text.back() != '_' && text.find("__") == std::string_view::npos &&
         std::all_of(text.begin(), text.end(), allowed);
}

/// What the user wants, checked against the stages there are. Throws ConfigError.
Names names_of(const std::string& stage, const plugin::Catalog& catalog) {
  const std::size_t slash = stage.find('/');
  if (slash == std::string::npos) {
    throw ConfigError(fmt::format("name the stage as FAMILY/NAME, for example windows/my_window, not '{}'", stage));
  }
  const Names names{stage.substr(0, slash), stage.substr(slash + 1)};
  const std::vector<std::string> families = catalog.families();
  if (std::find(families.begin(), families.end(), names.family) == families.end()) {
    const std::string near = nearest_name(names.family, families);
    throw ConfigError(fmt::format("unknown family '{}'{}; there are: {}", names.family,
                                  near.empty() ? "" : fmt::format(" (did you mean '{}'?)", near),
                                  fmt::join(families, ", ")));
  }
  if (!is_name(names.type)) {
    throw ConfigError(
        fmt::format("'{}' is no name for a stage: small letters, digits and single underscores between them, beginning "
                    "with a letter, {} at most, for example my_window",
                    names.type, kLongestName));
  }
  if (const auto* taken = catalog.find(names.family, names.type)) {
    throw ConfigError(
        fmt::format("there is a stage {}/{} already ({}); use another name", names.family, names.type, taken->origin));
  }
  return names;
}

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
  return text;
}

std::string filled(const std::string& text, const Names& names) {
  return replaced(replaced(replaced(text, "@family@", names.family), "my_stage", names.type), "MyStage",
                  names.class_name());
}

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in || !text) throw DataError(fmt::format("{}: cannot be read", file.string()));
  return text.str();
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw DataError(fmt::format("{}: cannot be written", file.string()));
}

/// Every file of a template, with the names filled in, also in its own.
void copy_filled(const fs::path& from, const fs::path& to, const Names& names) {
  for (const auto& entry : fs::recursive_directory_iterator(from)) {
    const fs::path target = to / filled(fs::relative(entry.path(), from).string(), names);
    if (entry.is_directory()) {
      fs::create_directories(target);
    } else {
      write(target, filled(content_of(entry.path()), names));
    }
  }
}

/// A folder beside the one to be made, which gets its name when it is complete.
class Unfinished {
 public:
  explicit Unfinished(const fs::path& folder) : folder_(folder) {
    std::string name = (folder.parent_path() / ("." + folder.filename().string() + "_XXXXXX")).string();
    if (mkdtemp(name.data()) == nullptr) {
      throw ConfigError(fmt::format("{}: cannot be made: {}", folder.string(), std::generic_category().message(errno)));
    }
    path_ = name;
  }
  ~Unfinished() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

  const fs::path& path() const { return path_; }
  void finish() const {
    fs::permissions(path_,
                    fs::perms::group_read | fs::perms::group_exec | fs::perms::others_read | fs::perms::others_exec,
                    fs::perm_options::add);
    fs::rename(path_, folder_);
  }

 private:
  fs::path folder_, path_;
};

/// The folder to be made, absolute and without a slash at its end. Throws ConfigError.
fs::path new_folder(const std::string& directory) {
  std::error_code error, ignored;
  fs::path folder = fs::absolute(directory, error).lexically_normal();
  if (error) throw ConfigError(fmt::format("{}: {}; give the whole path", directory, error.message()));
  if (!folder.has_filename()) folder = folder.parent_path();
  if (fs::symlink_status(folder, ignored).type() != fs::file_type::not_found) {
    throw ConfigError(fmt::format("{}: exists already; name a folder that does not", folder.string()));
  }
  if (!fs::is_directory(folder.parent_path(), ignored)) {
    throw ConfigError(
        fmt::format("{}: no such folder to make '{}' in", folder.parent_path().string(), folder.filename().string()));
  }
  return folder;
}

int new_plugin(const NewPluginArguments& a) {
  const Names names = names_of(a.stage, load_stages({}).catalog);
  const std::string directory = a.directory.empty() ? names.type : a.directory;
  const fs::path folder = new_folder(directory);
  const fs::path templates = data_path("templates/plugin");
  const fs::path pipeline = data_path("configs/pipelines/as_lio_plus.yaml");
  if (!fs::is_directory(templates / names.family)) {
    throw ConfigError(fmt::format("there is no template for the family '{}'", names.family));
  }
  try {
    const Unfinished unfinished(folder);
    copy_filled(templates / "common", unfinished.path(), names);
    copy_filled(templates / names.family, unfinished.path(), names);
    write(unfinished.path() / "study" / "as_lio_plus.yaml", content_of(pipeline));
    unfinished.finish();
  } catch (const fs::filesystem_error& error) {
    throw DataError(fmt::format("{}: cannot be written: {}", folder.string(), error.code().message()));
  }
  print(
      fmt::format("{}: the stage {}/{}; its README.md has the commands. First:\n"
                  "  cmake -S {} -B {}/build && cmake --build {}/build && ctest --test-dir {}/build\n",
                  folder.string(), names.family, names.type, directory, directory, directory, directory));
  return kSuccess;
}

}  // namespace

Command add_new_plugin(CLI::App& root) {
  CLI::App* app = root.add_subcommand("new-plugin",
                                      "Writes a project for a stage of your own: source, build, contract test, study.");
  auto arguments = std::make_shared<NewPluginArguments>();
  app->add_option("FAMILY/NAME", arguments->stage, "what to write, for example windows/my_window")->required();
  app->add_option("DIR", arguments->directory, "the folder to make; it may not exist; by default NAME");
  app->footer("Example:\n  aslio new-plugin windows/my_window my_window");
  return {app, [=] { return new_plugin(*arguments); }};
}

}  // namespace aslio::cli
