// Stands for `aslio` where a study needs one that misbehaves: `simulate` and `run` with the arguments of the real one.
// What a run does follows from the name of its method, its figures from its data, method and seed.
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

namespace {

namespace fs = std::filesystem;

std::string option(const std::vector<std::string>& words, const std::string& name) {
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    if (words[i] == name) return words[i + 1];
  }
  return {};
}

void pause_ms(int milliseconds) { std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds)); }

/// False when the file could not be written whole.
bool put(const fs::path& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  stream.close();
  return stream.good();
}

/// `world`: where its surface is asked for; empty: it is not.
int simulate(const fs::path& output, const std::string& world) {
  pause_ms(10);
  if (output.filename().string().find("broken") != std::string::npos) {
    std::fputs("error: there is no way through\n", stderr);
    return 3;
  }
  for (const char* file : {"data.bag", "sensor.yaml", "truth.tum", "overlap.csv", "scene.yaml", "preview.svg"}) {
    if (!put(output / file, std::string(3000, 's'))) return 3;
  }
  if (!world.empty() && !put(world, "ply\n")) return 3;
  return put(output / "dataset.yaml", "schema: aslio/dataset/1\n") ? 0 : 3;
}

double figure(const std::string& of) {
  std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a
  for (const char c : of) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return 0.1 + static_cast<double>(hash % 100000) * 1e-5;
}

std::string summary(const std::string& figure_text) {
  const auto noise = std::chrono::steady_clock::now().time_since_epoch().count() % 1000;
  return "{\"status\": \"ok\", \"reason\": \"\", \"updates\": 30, \"data_s\": 10, \"cpu_s\": 1." +
         std::to_string(noise) + ", \"peak_rss_mb\": 5" + std::to_string(noise) +
         ", \"metrics\": {\"ate_m\": " + figure_text + "}}\n";
}

void hoard() {
  std::vector<std::vector<char>> memory;
  for (int i = 0; i < 4000; ++i) {
    memory.emplace_back(4'000'000, 'x');
    pause_ms(5);
  }
}

/// Leaves a process behind that would run on, and says which.
int leave_behind(const fs::path& output) {
  const pid_t id = ::fork();
  if (id == 0) {
    for (;;) pause_ms(1000);
  }
  return put(output / "left_behind.txt", std::to_string(id)) ? 0 : 3;
}

/// Of a `--set window={type: replay, file: ".."}`.
bool schedule_is_there(const std::vector<std::string>& words) {
  const std::string begin = "window={type: replay, file: \"";
  for (const std::string& word : words) {
    if (!word.starts_with(begin)) continue;
    if (!fs::exists(word.substr(begin.size(), word.find('"', begin.size()) - begin.size()))) return false;
  }
  return true;
}

/// Changes a text that its study has read, while it is at work.
void edit(const fs::path& file) { std::ofstream(file, std::ios::app) << "# changed\n"; }

int run(const std::vector<std::string>& words) {
  const fs::path output = option(words, "--output"), data = option(words, "--dataset");
  const std::string name = output.filename();
  const std::string method = name.substr(1, name.find(".partial-") - 1);
  if (method == "edits_pipeline") edit(words[2]);
  if (method == "edits_truth") edit((fs::is_directory(data) ? data : data.parent_path()) / "truth.tum");
  for (const char* file : {"dataset.yaml", "data.bag", "sensor.yaml", "truth.tum"}) {
    if (!fs::exists(data / file)) return 3;
  }
  pause_ms(method == "patient" ? 1000 : 15);
  if (!schedule_is_there(words)) {
    std::fputs("error: window: cannot open the schedule\n", stderr);
    return 2;
  }
  std::string text = summary(std::to_string(figure(data.filename().string() + method + option(words, "--seed"))));
  int code = 0;
  if (method == "segv") ::raise(SIGSEGV);
  if (method == "hang") ::signal(SIGTERM, SIG_IGN);
  while (method == "hang") pause_ms(1000);
  if (method == "hoard") hoard();
  if (method == "not_a_number") text = summary("NaN");
  if (method == "garbage") text = std::string("\x7f\x45\x4c\x46\0\xff{]", 8);
  if (method == "unknown") text.replace(text.find("ok"), 2, "splendid");
  if (method == "liar") code = 1;
  if (method == "degraded") {
    text.replace(text.find("ok"), 2, "degraded");
    code = 4;
  }
  if (method == "degraded_liar") text.replace(text.find("ok"), 2, "degraded");
  if (method == "unmeasured") {
    text = R"({"status": "ok", "reason": "", "metrics": {"error": "truth.tum:3: no number"}})";
    code = 3;
  }
  if (method == "mute") return 1;
  if (method == "forks" && leave_behind(output) != 0) return 3;
  if (!put(output / "trajectory.tum", std::string(6000, '1'))) return 3;
  if (!put(output / "updates.csv", "t_ns\n1\n")) return 3;
  return put(output / "summary.json", text) ? code : 3;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv, argv + argc);
  if (words.size() < 2) return 2;
  return words[1] == "simulate" ? simulate(option(words, "--output"), option(words, "--save-world")) : run(words);
}
