"""Writes the tiny ONNX models that the tests load: `python make_models.py`. Random weights, fixed seeds; needs onnx.

conv4, set4 and bins7 are small cousins of the networks that gonio ships; light3 and light9 take a light; the rest each break one
line of the contract, and are named for it."""

from pathlib import Path

import numpy as np
from onnx import TensorProto, checker, helper, numpy_helper, save

FOLDER = Path(__file__).parent / "models"
BINS = 60 * 120
METADATA = {"gonio.kind": "lobe", "gonio.version": "test", "gonio.training": '{"data": "none, random weights"}'}


class Graph:
    """Nodes and weights, named as they are added."""

    def __init__(self, seed):
        self.nodes, self.weights, self.random = [], [], np.random.default_rng(seed)

    def weight(self, array):
        name = f"w{len(self.weights)}"
        self.weights.append(numpy_helper.from_array(np.asarray(array), name))
        return name

    def normal(self, *shape):
        fan_in = int(np.prod(shape[1:])) if len(shape) == 4 else shape[0]
        return self.weight((self.random.standard_normal(shape) * np.sqrt(2 / fan_in)).astype(np.float32))

    def ints(self, *values):
        return self.weight(np.array(values, np.int64))

    def add(self, op, *inputs, outputs=1, **attributes):
        names = [f"v{len(self.nodes)}_{i}" for i in range(outputs)]
        self.nodes.append(helper.make_node(op, list(inputs), names, **attributes))
        return names[0] if outputs == 1 else names

    def dense(self, x, n_in, n_out):
        return self.add("Add", self.add("MatMul", x, self.normal(n_in, n_out)), self.normal(1, n_out))


def write(name, graph, mu, map_shape=("N", 4, 60, 120), map_type=TensorProto.FLOAT, more_inputs=(), width=7,
          map_name="map", mu_name="mu", more_outputs=(), metadata=METADATA, sound=True):
    graph.nodes.append(helper.make_node("Identity", [mu], [mu_name]))
    inputs = [helper.make_tensor_value_info(map_name, map_type, map_shape)]
    inputs += [helper.make_tensor_value_info(n, TensorProto.FLOAT, s) for n, s in more_inputs]
    outputs = [helper.make_tensor_value_info(mu_name, TensorProto.FLOAT, (map_shape[0], width))]
    outputs += [helper.make_tensor_value_info(n, TensorProto.FLOAT, (map_shape[0], 7)) for n in more_outputs]
    model = helper.make_model(helper.make_graph(graph.nodes, "g", inputs, outputs, graph.weights),
                              opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    helper.set_model_props(model, metadata)
    if sound:
        checker.check_model(model)
    save(model, FOLDER / f"{name}.onnx")


def conv4():
    g = Graph(1)
    x = g.add("Relu", g.add("Conv", "map", g.normal(6, 4, 10, 10), strides=[10, 10]))
    x = g.add("Relu", g.add("Conv", x, g.normal(8, 6, 3, 3), pads=[1, 1, 1, 1], strides=[2, 2]))
    x = g.add("Relu", g.dense(g.add("Flatten", x), 8 * 3 * 6, 33))
    write("conv4", g, g.add("Sigmoid", g.dense(x, 33, 7)))


def set4(points=24, width=19):
    g = Graph(2)
    x = g.add("Reshape", "map", g.ints(0, 4, BINS))
    coverage = g.add("Slice", x, g.ints(3), g.ints(4), g.ints(1))
    priority = g.weight((1 + g.random.permutation(BINS) / BINS).astype(np.float16))
    score = g.add("Mul", coverage, g.add("Cast", priority, to=TensorProto.FLOAT))
    _, index = g.add("TopK", score, g.ints(points), axis=2, outputs=2)
    taken = g.add("GatherElements", x, g.add("Expand", index, g.ints(1, 4, 1)), axis=2)
    place = g.add("Mul", g.add("Cast", index, to=TensorProto.FLOAT), g.weight(np.float32(1 / BINS)))
    x = g.add("Transpose", g.add("Concat", taken, place, axis=1), perm=[0, 2, 1])
    mask = g.add("Slice", x, g.ints(3), g.ints(4), g.ints(2))
    x = g.add("Relu", g.dense(g.add("Relu", g.dense(x, 5, width)), width, width))
    total = g.add("ReduceSum", g.add("Mul", x, mask), g.ints(1), keepdims=0)
    count = g.add("Max", g.add("ReduceSum", mask, g.ints(1), keepdims=0), g.weight(np.float32(1)))
    most = g.add("ReduceMax", g.add("Mul", x, mask), axes=[1], keepdims=0)
    x = g.add("Concat", g.add("Div", total, count), most, axis=1)
    write("set4", g, g.add("Sigmoid", g.dense(x, 2 * width, 7)))


BINS_24 = METADATA | {"gonio.bins": "24"}


def bins7(name="bins7", width=17, shape=("N", "S", 7), metadata=BINS_24):
    g = Graph(5)
    mask = g.add("Cast", g.add("Greater", g.add("Slice", "bins", g.ints(6), g.ints(7), g.ints(2)), g.weight(np.float32(0))),
                 to=TensorProto.FLOAT)
    x = g.add("Mul", g.add("Relu", g.dense("bins", shape[2], width)), mask)
    total, most = g.add("ReduceSum", x, g.ints(1), keepdims=0), g.add("ReduceMax", x, axes=[1], keepdims=0)
    x = g.add("Concat", g.add("Mul", total, g.weight(np.float32(1 / 24))), most, axis=1)
    write(name, g, g.add("Sigmoid", g.dense(x, 2 * width, 7)), shape, map_name="bins", metadata=metadata)


def pooled(g, channels=4, width=7, source="map"):
    """The smallest graph with the right ends: the mean of each channel, and one dense layer."""
    x = g.add("Flatten", g.add("GlobalAveragePool", source))
    return g.add("Sigmoid", g.dense(x, channels, width))


def lit(values):
    g = Graph(3)
    x = g.add("Concat", g.add("Flatten", g.add("GlobalAveragePool", "map")), "light", axis=1)
    mu = g.add("Sigmoid", g.dense(x, 3 + values, 7))
    write(f"light{values}", g, mu, ("N", 3, 60, 120), more_inputs=[("light", ("N", values))])


def broken():
    def plain(name, *, graph=None, mu=None, channels=4, width=7, source="map", **rest):
        graph = graph or Graph(4)
        write(name, graph, mu or pooled(graph, channels, width, source), width=width, **rest)

    plain("sphere", metadata=METADATA | {"gonio.kind": "sphere"})
    plain("bad_kind", metadata=METADATA | {"gonio.kind": "cube"})
    plain("bad_training", metadata=METADATA | {"gonio.training": "[1, 2"})
    plain("bare_training", metadata=METADATA | {"gonio.training": "3"})
    plain("no_metadata", metadata={})
    plain("no_version", metadata={k: v for k, v in METADATA.items() if k != "gonio.version"})
    plain("rows_61", map_shape=("N", 4, 61, 120))
    plain("channels_5", channels=5, map_shape=("N", 5, 60, 120))
    plain("outputs_8", width=8)
    plain("fixed_batch", map_shape=(1, 4, 60, 120))
    plain("map_misnamed", source="image", map_name="image")
    plain("mu_misnamed", mu_name="y")
    g = Graph(4)
    plain("map_f64", graph=g, mu=pooled(g, source=g.add("Cast", "map", to=TensorProto.FLOAT)),
          map_type=TensorProto.DOUBLE)
    g = Graph(4)
    x = g.add("Add", pooled(g), "gain")
    plain("extra_input", graph=g, mu=x, more_inputs=[("gain", ("N", 7))])
    g = Graph(4)
    x = pooled(g)
    g.nodes.append(helper.make_node("Identity", [x], ["also"]))
    plain("extra_output", graph=g, mu=x, more_outputs=["also"])
    g = Graph(4)
    x = pooled(g)
    plain("nan_on_empty", graph=g, mu=g.add("Div", g.add("Sub", x, x), g.add("Sub", x, x)))
    g = Graph(4)
    plain("out_of_range", graph=g, mu=g.add("Add", pooled(g), g.weight(np.float32(1))))
    g = Graph(4)
    x = g.add("Reshape", g.add("Concat", pooled(g), pooled(g), axis=1), g.ints(-1, 7))
    plain("two_rows_a_map", graph=g, mu=x)
    g = Graph(4)
    x = pooled(g)
    outside = next(w for w in g.weights if w.raw_data)
    outside.ClearField("raw_data")
    outside.data_location = TensorProto.EXTERNAL
    outside.external_data.add(key="location", value="make_models.py")
    plain("weights_outside", graph=g, mu=x, sound=False)
    g = Graph(4)
    x = pooled(g)
    next(w for w in g.weights if w.raw_data).dims[0] = 1 << 40
    plain("huge_weight", graph=g, mu=x, sound=False)
    bins7("bins_8", shape=("N", "S", 8))
    bins7("fixed_bins", shape=("N", 24, 7))
    bins7("bad_deviation", metadata=BINS_24 | {"gonio.deviation": "[0.1, 0, 2]"})
    bins7("no_bins", metadata=METADATA)
    bins7("bins_zero", metadata=METADATA | {"gonio.bins": "0"})


if __name__ == "__main__":
    conv4()
    set4()
    bins7(metadata=BINS_24 | {"gonio.deviation": "[0.1,0.1,0.1,0.2,0.2,0.2,0.25]"})
    lit(3)
    lit(9)
    broken()
