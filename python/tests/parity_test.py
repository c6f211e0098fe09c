"""Python, C++ and the command line have the same names, defaults and meanings."""

import dataclasses
import inspect
import json
import pathlib
import re

import pytest

import consimd

ROOT = pathlib.Path(__file__).parents[2]

# Of C++ alone: it reads files, other types of points, and names, which Python hands over as arrays and texts; lengths
# in the working frame are the caller's times Correspondences.scale.
CPP_ALONE = {
    "kernels": {"to_string", "parse_isa", "gather", "pcl_correspondences", "matches_subset", "working_length",
                "neighbours_within", "neighbourhood_scatter", "principal_axes", "pair_feature_counts",
                 "weighted_histogram_sum", "best_matches", "nearest_within",
                "move_pairs", "pair_residuals", "pair_equations"}
    # What elementary_functions.hpp has is of the library's own use; NumPy has such.
    | {"log", "log10", "log1p", "exp", "expm1", "tanh", "cbrt", "sine_cosine", "atan2", "asin", "acos"},
    "poses": {"column_points", "row_points", "points_of", "point_pairs"},
    "synth": {"stand_in", "problem_family", "read_correspondences", "read_pose", "read_scaled_pose", "read_problem",
              "write_pose", "pose_text", "nearest_pose", "labelled_problem"}
    | {"with_far_rows", "with_rows_without_depth", "repeated_targets", "all_to_all", "symmetric_part"}
    | {"read_text", "remove_abandoned_files"},
    # Files, the parts that match_clouds is made of, and what consimd.features calls normals.
    "features": {"read_cloud", "choose_voxel", "occupied_voxels", "random_subset", "radius_neighbours", "resolution",
                 "estimate_normals", "refine_registration", "parse_refinement_method", "to_string", "moved_ply",
                 "verify_registration", "decide", "is_borne_out", "has_equal_rival", "has_rival_in_doubt",
                 "agrees_better_scaled", "is_of_another_scale", "read_array_matches", "read_matched_rows", "read_indexed_matches"},
}
# Of Python alone: classes, and bit sets as masks.
PYTHON_ALONE = {
    "kernels": {"ConsistencyMatrix", "Correspondences", "RigidFit", "RigidMoments", "pack_bits", "unpack_bits"},
    "synth": {"Problem"},
    "features": {"CloudMatches", "CloudSummary", "CloudVerdict", "PoseEvidence", "Refinement", "RefinementStatus",
                 "RivalPose", "normals"},
}
RENAMED = {"T_target_source": "pose"}


def headers(library):
    folder = ROOT / library / "include"
    return {header.name: header.read_text() for header in sorted(folder.rglob("*.hpp"))}


def functions(library):
    """Names of the functions that are declared at the left margin."""
    declaration = r"^(?:\[\[nodiscard\]\] )?(?:inline |constexpr )*[A-Za-z_][\w:<>&, *]*?[ &](\w+)\("
    names = set()
    for text in headers(library).values():
        for match in re.finditer(declaration, text, re.MULTILINE):
            if not match[0].startswith(("static_assert", "return ", "using ", "#", "struct ")):
                names.add(match[1])
    return names


def body_of(kind, name, library="solvers"):
    """Lines between the braces of a struct or an enumeration."""
    for text in headers(library).values():
        match = re.search(rf"^{kind} {name}(?: : [\w:]+)? {{\n(.*?)^}};", text, re.MULTILINE | re.DOTALL)
        if match:
            return match[1]
    raise AssertionError(f"no {kind} {name}")


def members(name, library="solvers"):
    """Members of a struct, as Python calls them."""
    found = re.findall(r"^  [\w:<>,]+(?: [\w:<>,]+)* (\w+)(?: = [^;]*)?;", body_of("struct", name, library), re.MULTILINE)
    return [RENAMED.get(member, member) for member in found]


def test_functions_on_arrays_are_those_of_the_library():
    there = functions("kernels") | functions("poses")
    assert there >= CPP_ALONE["kernels"] | CPP_ALONE["poses"]
    assert set(consimd.kernels.__all__) - PYTHON_ALONE["kernels"] == there - CPP_ALONE["kernels"] - CPP_ALONE["poses"]


def test_synthetic_problems_are_those_of_the_library():
    there = functions("synth")
    assert there >= CPP_ALONE["synth"]
    assert set(consimd.synth.__all__) - PYTHON_ALONE["synth"] == there - CPP_ALONE["synth"]


def test_features_are_those_of_the_library():
    there = functions("features")
    assert there >= CPP_ALONE["features"]
    own = set(consimd.features.__all__) - PYTHON_ALONE["features"] | {"register_clouds"}
    assert own == there - CPP_ALONE["features"]
    # Python has a distance in place of a match, and no Correspondences.
    names = set(members("CloudMatches", "features"))
    fields = {field.name for field in dataclasses.fields(consimd.features.CloudMatches)}
    assert names - {"correspondences", "matches", "source_voxels", "target_voxels"} == fields - {"distances"}
    assert [field.name for field in dataclasses.fields(consimd.features.Refinement)] == members("Refinement", "features")
    statuses = re.findall(r"^  (\w+),", body_of("enum class", "RefinementStatus", "features"), re.MULTILINE)
    assert [status.value for status in consimd.features.RefinementStatus] == statuses
    methods = re.findall(r"^  (\w+),", body_of("enum class", "RefinementMethod", "features"), re.MULTILINE)
    assert inspect.get_annotations(consimd.features.refine)["method"] == f"Literal{methods}"
    assert list(consimd.features.CloudSummary._fields) == members("CloudSummary", "features")


def test_defaults_of_features_are_those_of_the_library():
    """Of the options structs, and of the command where it has the option."""
    parameters = inspect.signature(consimd.features.match_clouds).parameters
    matching, match = body_of("struct", "CloudMatchingOptions", "features"), body_of("struct", "MatchOptions", "features")
    for body, names in ((matching, ["normal_radius", "descriptor_radius", "keypoints", "farthest", "iss", "iss_radius",
                                      "iss_suppression_radius", "seed"]),
                        (match, ["best", "mutual", "ratio"])):  # fmt: skip
        for name in names:
            (value,) = re.findall(rf" {name} = ([\w.]+);", body)
            assert json.loads(value) == parameters[name].default, name
    for name in ("best", "mutual", "ratio"):
        assert inspect.signature(consimd.features.match).parameters[name].default == parameters[name].default
    assert matching.count("_viewpoint = std::array<double, 3>{0.0, 0.0, 0.0};") == 2
    iss = inspect.signature(consimd.features.iss_keypoints).parameters
    for name in ("second_to_first", "third_to_second", "fewest_neighbours"):
        (value,) = re.findall(rf" {name} = ([\w.]+);", body_of("struct", "IssOptions", "features"))
        assert json.loads(value) == iss[name].default, name
    refine = inspect.signature(consimd.features.refine).parameters
    (value,) = re.findall(r" max_iterations = (\d+);", body_of("struct", "RefinementOptions", "features"))
    assert json.loads(value) == refine["max_iterations"].default
    assert refine["normal_radius"].default == parameters["normal_radius"].default
    assert f"RefinementMethod::{refine['method'].default};" in body_of("struct", "RefinementOptions", "features")
    for name in ("source_viewpoint", "target_viewpoint"):
        assert parameters[name].default == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("name", ["match", "register"])
def test_defaults_of_clouds_are_those_of_the_command(command, name):
    parameters = inspect.signature(consimd.features.match_clouds).parameters
    shown = defaults_of_the_command(command, name)
    assert shown["keypoints"] == f"random:{parameters['keypoints'].default}"
    assert shown["matches"] == f"mutual:{parameters['best'].default}" and parameters["mutual"].default
    assert shown["seed"] == str(parameters["seed"].default)


def test_consistency_matrices_are_those_of_the_library():
    text = headers("kernels")["consistency_matrix.hpp"]
    assert set(re.findall(r"void (compute\w*)\(", text)) == {"compute", "compute_separated", "compute_ratio"}
    constructor = consimd.kernels.ConsistencyMatrix.__init__.__doc__
    assert "separation" in constructor and "ratio_bound" in constructor


def test_results_have_the_members_of_the_library():
    fields = lambda kind: [field.name for field in dataclasses.fields(kind)]
    own = {"correspondences", "solver", "filter"}  # what its caller knows
    own |= {"residuals", "sigma", "geometry", "other_scale", "odd_row"}  # of AssumedInliers
    own |= {"refinement", "verdict", "attempts"}  # of CloudRegistration
    assert set(fields(consimd.Registration)) - own == set(members("Registration"))
    assert set(fields(consimd.RunnerUp)) == set(members("RunnerUp"))
    assert fields(consimd.Stage) == members("StageReport")
    assert list(consimd.NoiseBoundEstimate._fields) == members("NoiseBoundEstimate")


def test_statuses_are_those_of_the_library():
    names = re.findall(r"^  (\w+),", body_of("enum class", "Status"), re.MULTILINE)
    assert [status.value for status in consimd.Status] == names


def test_solvers_are_those_of_the_command(command):
    assert list(consimd.solvers()) == json.loads(command("info", "--json"))["solvers"]
    for name, description in consimd.solvers().items():
        assert json.loads(command("info", "--solver", name, "--json"))["description"] == description


@pytest.mark.parametrize("solver", consimd.solvers())
def test_options_are_those_of_the_command(command, solver):
    listed = json.loads(command("info", "--solver", solver, "--json"))["options"]
    described = consimd.describe_options(solver)
    assert list(described) == [option["name"] for option in listed]
    for option in listed:
        assert described[option["name"]] == (option["value"], option["unit"], option["expected"], option["meaning"])
    assert consimd.solver_options(solver) == {option["name"]: option["value"] for option in listed}
    assert all(type(described[option["name"]].default) is type(option["value"]) for option in listed)


# The names of the options structs; those of the presets are their solver's.
OPTIONS_STRUCTS = {
    "tcf": "TcfOptions",
    "tcf-published": "TcfPublishedOptions",
    "ransac": "RansacOptions",
    "sc2_pcr": "Sc2PcrOptions",
    "turboreg": "TurboRegOptions",
    "pcr99": "Pcr99Options",
    "teaser": "TeaserOptions",
    "mac": "MacOptions",
}


@pytest.mark.parametrize("solver", OPTIONS_STRUCTS)
def test_options_are_the_members_of_the_library(solver):
    """All of them: what a header declares can be set by name."""
    body = re.sub(r"enum class[^{]*{[^}]*}", "Enum", body_of("struct", OPTIONS_STRUCTS[solver]))
    names = re.findall(r"^  [\w:<>]+ (\w+)(?: = [^;]*)?;", body, re.MULTILINE)
    # What every solver is given.
    task = {"noise_bound", "seed", "bounds_tried", "threads", "stop"}
    assert task - {"bounds_tried"} < set(names)
    assert list(consimd.solver_options(solver)) == [name for name in names if name not in task]


def defaults_of_the_command(command, name):
    """What the help of a command shows behind the type of an option, as in --seed UINT=1."""
    shown = re.findall(r"^  --([\w-]+) [A-Z]+=(\S+)", command(name, "--help"), re.MULTILINE)
    return {option.replace("-", "_"): value.strip("[]") for option, value in shown}


def test_defaults_are_those_of_the_command(command):
    parameters = inspect.signature(consimd.register).parameters
    shown = defaults_of_the_command(command, "register")
    assert shown["seed"] == str(parameters["seed"].default)
    assert shown["solver"] == parameters["solver"].default
    assert shown["filter"] == parameters["filter"].default
    assert parameters["noise_bound"].default is None and "noise_bound" not in shown
    assert inspect.signature(consimd.estimate_noise_bound).parameters["seed"].default == parameters["seed"].default

    parameters = inspect.signature(consimd.sweep).parameters
    shown = defaults_of_the_command(command, "sweep")
    for name in ("points", "trials", "seed", "filter"):
        assert shown[name] == str(parameters[name].default), name
    assert shown["solver"] == ",".join(parameters["solvers"].default)
    assert shown["outliers"] == ",".join(map(str, parameters["outliers"].default))
    assert float(shown["time_limit"]) == parameters["time_limit"].default

    parameters = inspect.signature(consimd.compare).parameters
    shown = defaults_of_the_command(command, "compare")
    for name in ("trials", "points", "seed", "seeds", "filter", "thresholds", "iteration_problems"):
        assert shown[name] == str(parameters[name].default), name
    assert shown["table"] == ",".join(parameters["tables"].default)
    assert float(shown["time_limit"]) == parameters["time_limit"].default
    assert parameters["solvers"].default is None and shown["solver"] == ",".join(consimd.solvers())


def test_seeds_start_at_one():
    """Everywhere: in the library, in the command, here."""
    for function in (consimd.register, consimd.estimate_noise_bound, consimd.sweep, consimd.compare,
                     consimd.register_clouds, consimd.features.match_clouds):  # fmt: skip
        assert inspect.signature(function).parameters["seed"].default == 1
    for library in ("solvers", "synth", "features"):
        for name, text in headers(library).items():
            for default in re.findall(r"uint64_t seed = (\d+)", text):
                # That of a result says nothing before there is one.
                assert default == ("0" if name == "registration.hpp" else "1"), name
