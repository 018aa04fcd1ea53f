"""Functions are short and have few parameters: at most 80 lines and 7 parameters in core/ and bindings/."""

from __future__ import annotations

from pathlib import Path

import pytest
from cpp_functions import Function, functions

ROOT = Path(__file__).resolve().parents[2]
MAX_LINES = 80
MAX_PARAMETERS = 7
# Tables in the form of code: one line or case for each entry, without control flow between them.
TABLES = {
    "run_at": "the switch over all instructions of register programs",
    "bind_geometry": "bindings", "bind_light_world_camera": "bindings", "bind_description": "bindings", "bind_session": "bindings",
}
# Functions of the Python module. Their parameters are keyword arguments of Python, where each has its name at the call.
KEYWORDS = {"read_mesh", "make_strands", "add_object", "add_image"}
SOURCES = sorted(path for folder in ("core", "bindings") for path in (ROOT / folder).rglob("*") if path.suffix in {".h", ".cpp"})
FOUND = [(path, function) for path in SOURCES for function in functions(path.read_text())]


def test_functions_are_short():
    long = {f"{path.relative_to(ROOT)}:{f.line} {f.name}": f.lines for path, f in FOUND if f.lines > MAX_LINES and f.name not in TABLES}
    assert not long, long


def test_functions_have_few_parameters():
    many = {f"{path.relative_to(ROOT)}:{f.line} {f.name}": f.parameters for path, f in FOUND
            if f.parameters > MAX_PARAMETERS and not (path.is_relative_to(ROOT / "bindings") and f.name in KEYWORDS)}
    assert not many, many


def test_every_exemption_is_needed():
    assert set(TABLES) == {f.name for _, f in FOUND if f.lines > MAX_LINES}
    assert set(KEYWORDS) == {f.name for _, f in FOUND if f.parameters > MAX_PARAMETERS}


def test_the_counter_finds_the_functions_of_the_core():
    names = [f.name for _, f in FOUND]
    assert len(names) > 2000
    for name in ("ShaderProgram::evaluate_surface", "Camera::Camera", "operator*", "LightMixture::for_each_draw", "PathWalk"):
        assert name in names, name
    assert not {"if", "for", "while", "switch", "return", "catch"} & set(names)


EXAMPLE = '''#define LOOP(x) \\
  for (;;) { x
namespace ajar {
namespace {
// A brace in a comment: {
constexpr int kTable[] = {1, 2, 3}, kOther{4};
const std::function<int(int, int)> kSum = [](int a, int b) { return a + b; };
enum class Kind : uint8_t { A, B };
int none() { return 1'000 + '{'; }
}  // namespace
template <class F = void (*)(int, int), int N = (1, 2)>
class Thing : public Base<int, float> {
 public:
  explicit Thing(int a, const std::map<int, float>& b = {{1, 2.0f}})
      : a_{a},
        b_(b),
        c_{1, 2} {
    if (a > 0) {
      const char* text = "}";
      (void)text;
    }
  }
  [[nodiscard]] bool operator()(int x, int y) const { return x < y; }
  auto begin() const noexcept -> Pair<int, int> { return {1, 2}; }
  int a_ = 0, d_{5};
  struct { int x; } inner;
};

[[gnu::noinline]] static Color
long_one(
    const std::function<void(int, int)>& f, int a, float (&array)[3], int b = std::max(1, 2),
    void (*callback)(int, int) = nullptr, Pair<int, int> p = Pair<int, int>{1, 2}, int g = 1, int h = 2) {
  const auto visit = [&](int i) {
    return i;
  };
  return f(a, visit(b));
}
bool operator==(const Thing& a, const Thing& b) { return a.a_ == b.a_; }
int declared(int a, int b);
TEST(Suite, name) {
}
}  // namespace ajar
'''


def test_the_counter_reads_the_layout_of_clang_format():
    assert functions(EXAMPLE) == [
        Function("none", 9, 1, 0),
        Function("Thing", 14, 9, 2),
        Function("operator()", 23, 1, 2),
        Function("begin", 24, 1, 0),
        Function("long_one", 29, 9, 8),
        Function("operator==", 38, 1, 2),
        Function("TEST", 40, 2, 2),
    ]


def test_the_counter_refuses_what_it_does_not_understand():
    with pytest.raises(ValueError, match="stay open"):
        functions("void f() {\n  if (true) {\n}\n")


def test_the_counter_measures_a_function_that_grows():
    for lines in (1, 80, 81):
        body = "".join(f"  f({i});\n" for i in range(lines - 2))
        source = "int x;\nvoid f() {\n" + body + "}\n" if lines > 1 else "int x;\nvoid f() {}\n"
        assert functions(source) == [Function("f", 2, lines, 0)]
