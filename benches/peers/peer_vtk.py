#!/usr/bin/env python3
"""VTK's physically based shading through its Python wheel, on Mesa's llvmpipe.

VTK's glTF reader leaves the coat out; it is set here on the actor. With --environment VTK filters the picture anew in
every process, which is most of the cold figure.
"""

import os
import sys
import time

os.environ.setdefault("LIBGL_ALWAYS_SOFTWARE", "1")

import common

STARTUP = time.process_time()

try:
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 (chooses OpenGL for what follows)
    from vtkmodules.vtkCommonCore import vtkObject, vtkUnsignedCharArray, vtkVersion
    from vtkmodules.vtkIOImage import vtkHDRReader, vtkPNGWriter
    from vtkmodules.vtkIOImport import vtkGLTFImporter
    from vtkmodules.vtkRenderingCore import (
        vtkLight,
        vtkRenderer,
        vtkRenderWindow,
        vtkTexture,
        vtkWindowToImageFilter,
    )
except ImportError as error:
    common.missing(f"{error} (pip install vtk)")


class Program:
    def __init__(self, args):
        self.args = args
        # The reader warns of the coat once a model.
        vtkObject.GlobalWarningDisplayOff()
        self.renderer = vtkRenderer()
        self.renderer.SetBackground(*common.BACKGROUND)
        self.renderer.SetAutomaticLightCreation(False)
        self.window = vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetSize(args.width, args.height)
        self.window.SetMultiSamples(args.samples if args.samples > 1 else 0)
        self.window.AddRenderer(self.renderer)
        self.version = f"VTK {vtkVersion.GetVTKVersion()} ({self.window.GetClassName()})"
        self.pixels = vtkUnsignedCharArray()
        self.light = vtkLight()
        self.light.SetLightTypeToSceneLight()
        self.light.SetPosition(*common.LIGHT)
        self.light.SetFocalPoint(0.0, 0.0, 0.0)
        # With 3 the diffuse part is as bright as F3D draws it from the file.
        self.light.SetIntensity(3.0)
        if args.environment:
            reader = vtkHDRReader()
            reader.SetFileName(args.environment)
            texture = vtkTexture()
            texture.SetColorModeToDirectScalars()
            texture.MipmapOn()
            texture.InterpolateOn()
            texture.SetInputConnection(reader.GetOutputPort())
            self.renderer.UseImageBasedLightingOn()
            self.renderer.UseSphericalHarmonicsOn()
            self.renderer.SetEnvironmentTexture(texture, False)

    def load(self, path):
        self.renderer.RemoveAllViewProps()
        self.importer = vtkGLTFImporter()
        self.importer.SetFileName(path)
        self.importer.SetRenderWindow(self.window)
        self.importer.Update()
        layer = common.paint(path).get("extensions", {}).get("KHR_materials_clearcoat", {})
        actors = self.renderer.GetActors()
        actors.InitTraversal()
        for _ in range(actors.GetNumberOfItems()):
            surface = actors.GetNextActor().GetProperty()
            surface.SetInterpolationToPBR()
            surface.SetCoatStrength(layer.get("clearcoatFactor", 0.0))
            surface.SetCoatRoughness(layer.get("clearcoatRoughnessFactor", 0.0))
        # The same light for every version, whether it reads those of the file or not.
        self.renderer.RemoveAllLights()
        self.renderer.AddLight(self.light)

    def draw(self, k, n):
        camera = self.renderer.GetActiveCamera()
        camera.SetPosition(*common.eye(k, n))
        camera.SetFocalPoint(0.0, 0.0, 0.0)
        camera.SetViewUp(0.0, 1.0, 0.0)
        camera.SetViewAngle(common.FIELD_OF_VIEW)
        camera.SetClippingRange(common.NEAR, common.FAR)
        self.window.Render()

    def frame(self, k, n):
        self.draw(k, n)
        self.window.GetRGBACharPixelData(0, 0, self.args.width - 1, self.args.height - 1, 0, self.pixels)

    def picture(self, path):
        self.draw(0, 1)
        grab = vtkWindowToImageFilter()
        grab.SetInput(self.window)
        grab.ReadFrontBufferOff()
        grab.ShouldRerenderOff()
        writer = vtkPNGWriter()
        writer.SetFileName(path)
        writer.SetInputConnection(grab.GetOutputPort())
        writer.Write()

    def model(self, path):
        self.load(path)
        self.frame(0, 1)


def main():
    args = common.arguments(__doc__)
    program = Program(args)
    if args.mode == "probe":
        common.finish({"peer": "vtk", "version": program.version})
        return
    if args.mode != "models":
        program.load(args.model[0])
    common.run(args, "vtk", program.version, STARTUP, program.picture, program.frame, program.model)


if __name__ == "__main__":
    sys.exit(main())
