"""Sources that are compiled as one share no name (tools/lib/neighbours.py)."""
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools/lib"))
import neighbours


class Neighbours(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def groups(self, *texts, size=8):
        """The groups of sources a, b, c .. with these texts, as words: ["ab", "c"]."""
        paths = []
        for letter, text in zip("abcdefghijklmnop", texts):
            paths.append(f"{self.folder.name}/{letter}.cpp")
            pathlib.Path(paths[-1]).write_text(text, encoding="utf-8")
        neighbours.included.cache_clear()  # the same paths have had other texts
        return ["".join(pathlib.Path(path).stem for path in group) for group in neighbours.groups(paths, size)]

    @staticmethod
    def unnamed(text):
        return f"namespace x {{\nnamespace {{\n\n{text}\n\n}}  // namespace\n}}  // namespace x\n"

    def test_sources_with_names_of_their_own_are_one(self):
        self.assertEqual(self.groups(self.unnamed("int one() { return 1; }"), self.unnamed("int two() { return 2; }")), ["ab"])

    def test_each_kind_of_name_parts_two_sources(self):
        for declared in ("int f(int a) {\n  return a;\n}", "constexpr int f = 2;", "struct f {\n  int a;\n};", "using f = int;",
                         "template <class T>\nstd::vector<T> f(const T& a);", "enum class f { a };", "const char* const f[] = {\n};",
                         "std::map<int, double> f(\n    int a);", "[[noreturn]] void f(int a);", "constexpr int f[] = {1};",
                         "std::function<double(double)> f(int a);", "Eigen::Matrix<double, 6, -1> f(int a);", "enum Part { f = 1 };",
                         "struct alignas(64) f {\n  int a;\n};", "std::array<int, 3 + 1> f{};", "bool f = false;"):
            with self.subTest(declared):
                self.assertEqual(self.groups(self.unnamed(declared), self.unnamed("double f(double b) { return b; }")), ["a", "b"])
                # Not only where both declare it: a call must mean what it means in a source by itself.
                self.assertEqual(self.groups(self.unnamed(declared), "void g() { f(2); }\n"), ["a", "b"])

    def test_a_name_behind_the_end_of_a_type_counts(self):
        for before in ("struct A {\n  int a;\n};", "struct A {\n  int a;\n};  // 24 bytes", "constexpr int W = 2;"):
            self.assertEqual(self.groups(self.unnamed(before + "\n\nint f() { return 1; }"), "int f();\n"), ["a", "b"])
        self.assertEqual(self.groups(self.unnamed("constexpr int W = 2;"), "int a = W;\n"), ["a", "b"])

    def test_what_is_declared_for_everybody_does_not_count(self):
        self.assertEqual(self.groups("namespace x {\nint f() { return 1; }\n}  // namespace x\n", "int g() { return f(); }\n"), ["ab"])
        self.assertEqual(self.groups(self.unnamed("int g() { return 1; }") + "\nint f() { return 1; }\n", "int h() { return f(); }\n"), ["ab"])

    def test_macros_and_static_functions_count(self):
        self.assertEqual(self.groups("#define LIMIT 2\n", "int a = LIMIT;\n"), ["a", "b"])
        self.assertEqual(self.groups("static int f() { return 1; }\n", "int f(double);\n"), ["a", "b"])
        self.assertEqual(self.groups("constexpr int f = 1;\n", "int a = f;\n"), ["a", "b"])

    def test_comments_and_texts_are_no_words(self):
        self.assertEqual(self.groups(self.unnamed("int f() { return 1; }"), '// f\nauto t = "f"; /* f\nf */ auto r = R"(f)";\n'), ["ab"])

    def test_a_name_of_a_header_that_the_other_alone_includes_counts(self):
        pathlib.Path(self.folder.name, "stage.hpp").write_text('#include "deep.hpp"\nclass Stage {\n  int size;\n};\n', encoding="utf-8")
        pathlib.Path(self.folder.name, "deep.hpp").write_text("double depth(int a);\n", encoding="utf-8")
        other = '#include "stage.hpp"\nint a();\n'
        for own in ("struct Stage {\n  int a;\n};", "int depth() { return 1; }"):
            self.assertEqual(self.groups(self.unnamed(own), other), ["a", "b"])
        self.assertEqual(self.groups(self.unnamed("int size() { return 1; }"), other), ["ab"])
        # Not to lean on an include of a neighbour, either.
        self.assertEqual(self.groups("int b() { return depth(1); }\n", other), ["a", "b"])
        self.assertEqual(self.groups("int b(Stage& s);\n", other), ["a", "b"])
        self.assertEqual(self.groups("int b() { return a.depth(1); }\n", other), ["ab"])
        both = '#include "stage.hpp"\n' + self.unnamed("int depth(double) { return 1; }")
        self.assertEqual(self.groups(both, other), ["ab"])

    def test_the_same_alias_twice_is_one(self):
        same = self.unnamed("using Json = nlohmann::json;")
        self.assertEqual(self.groups(same, same), ["ab"])
        self.assertEqual(self.groups(same, self.unnamed("using Json = int;")), ["a", "b"])

    def test_names_that_are_brought_in(self):
        brings = "using Catch::Contains;\n"
        self.assertEqual(self.groups(brings, brings + "bool a = Contains(1);\n"), ["ab"])
        self.assertEqual(self.groups(brings, "using Other::Contains;\n"), ["a", "b"])
        self.assertEqual(self.groups(brings, "bool a = Contains(1);\n"), ["a", "b"])

    def test_what_changes_the_compiler_is_alone(self):
        for line in ("#pragma GCC optimize(3)", "#undef LIMIT"):
            self.assertEqual(self.groups(line + "\n", "int a;\n", "int b;\n"), ["a", "bc"])

    def test_a_source_that_replaces_operator_new_is_alone(self):
        self.assertEqual(self.groups("void* operator new(std::size_t n) { return get(n); }\n", "int a;\n", "int b;\n"), ["a", "bc"])

    def test_a_group_has_a_size(self):
        self.assertEqual(self.groups(*["int a();\n"] * 5, size=2), ["ab", "cd", "e"])


if __name__ == "__main__":
    unittest.main()
